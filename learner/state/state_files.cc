#include "learner/state/state_files.h"

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/check.h"
#include "common/digest.h"
#include "common/policy/safetensors.h"
#include "common/status_macros.h"
#include "learner/learner.h"
#include "learner/state/newest_state.h"

namespace sinew::learner {
namespace {

using checkpoint::ArtifactFiles;

constexpr char kTensors[] = "tensors.safetensors";

std::string SnapshotFile(int64_t version) {
  return absl::StrCat("snapshot-", version);
}

std::string ChunkFile(const std::string& sha256) {
  return absl::StrCat("memory-", sha256);
}

Blob MakeBlob(std::string bytes) {
  return std::make_shared<const std::string>(std::move(bytes));
}

absl::StatusOr<Blob> Find(const ArtifactFiles& files, const std::string& path) {
  const auto found = files.find(path);
  if (found != files.end()) return found->second;
  return absl::DataLossError(
      absl::StrCat("training state: expected a file ", path, ", found none"));
}

absl::Status CheckDigest(const std::string& path, const std::string& expected,
                         const std::string& bytes) {
  const std::string found = Sha256Hex(bytes);
  if (found == expected) return absl::OkStatus();
  return absl::DataLossError(absl::StrCat(path, ": expected SHA-256 ", expected,
                                          ", found ", found));
}

absl::Status ReadTensors(const std::string& bytes, TensorMap& tensors) {
  absl::StatusOr<TensorMap> parsed = ParseSafetensors(bytes, kTensors);
  absl::Status status = parsed.status();
  if (status.ok()) status = CheckFinite(*parsed, kTensors);
  if (!status.ok()) return absl::DataLossError(status.message());
  tensors = *std::move(parsed);
  return absl::OkStatus();
}

}  // namespace

ArtifactFiles StateToFiles(const Trainer::State& state) {
  SINEW_CHECK(state.counters.snapshots_size() ==
                  static_cast<int>(state.snapshots.size()) &&
              state.counters.memory().chunks_size() ==
                  static_cast<int>(state.chunks.size()));
  ArtifactFiles files;
  files[kStateCounters] = MakeBlob(SerializeDeterministically(state.counters));
  files[kTensors] = MakeBlob(SerializeSafetensors(state.tensors));
  for (int i = 0; i < state.counters.snapshots_size(); ++i) {
    files[SnapshotFile(state.counters.snapshots(i).version())] =
        MakeBlob(state.snapshots[i]);
  }
  for (const StateChunk& chunk : state.chunks) {
    files[ChunkFile(chunk.sha256)] = chunk.bytes;
  }
  return files;
}

absl::StatusOr<Trainer::State> StateFromFiles(const ArtifactFiles& files) {
  Trainer::State state;
  SINEW_ASSIGN_OR_RETURN(const Blob counters, Find(files, kStateCounters));
  SINEW_ASSIGN_OR_RETURN(state.counters, ParseCounters(*counters));
  SINEW_ASSIGN_OR_RETURN(const Blob tensors, Find(files, kTensors));
  SINEW_RETURN_IF_ERROR(ReadTensors(*tensors, state.tensors));
  for (const v1::SnapshotReference& reference : state.counters.snapshots()) {
    const std::string path = SnapshotFile(reference.version());
    SINEW_ASSIGN_OR_RETURN(const Blob snapshot, Find(files, path));
    SINEW_RETURN_IF_ERROR(CheckDigest(path, reference.sha256(), *snapshot));
    state.snapshots.push_back(*snapshot);
  }
  for (const v1::MemoryState::Chunk& chunk : state.counters.memory().chunks()) {
    const std::string path = ChunkFile(chunk.sha256());
    SINEW_ASSIGN_OR_RETURN(Blob bytes, Find(files, path));
    SINEW_RETURN_IF_ERROR(CheckDigest(path, chunk.sha256(), *bytes));
    state.chunks.push_back({chunk.sha256(), std::move(bytes)});
  }
  return state;
}

}  // namespace sinew::learner
