#include "learner/state/state_files.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/status_macros.h"

namespace sinew::learner {
namespace {

constexpr char kPrefix[] = "state-";
constexpr char kCounters[] = "state.pb";
constexpr char kTensors[] = "tensors.safetensors";
constexpr char kDigests[] = "DIGESTS";

std::string SnapshotFile(int64_t version) {
  return absl::StrCat("snapshot-", version);
}

// Names of state folders, newest first.
std::vector<std::string> StateNames(const std::string& folder) {
  std::vector<std::string> names;
  const auto listing = ListDirectory(folder);
  if (!listing.ok()) return names;
  for (const std::string& name : *listing) {
    if (absl::StartsWith(name, kPrefix)) names.push_back(name);
  }
  std::sort(names.rbegin(), names.rend());
  return names;
}

// Contents of a state's files once every digest holds.
absl::StatusOr<std::map<std::string, std::string>> ReadVerified(
    const std::string& path) {
  SINEW_ASSIGN_OR_RETURN(const std::string digests,
                         ReadFile(JoinPath(path, kDigests)));
  std::map<std::string, std::string> files;
  for (absl::string_view line :
       absl::StrSplit(digests, '\n', absl::SkipEmpty())) {
    const std::vector<std::string> parts = absl::StrSplit(line, "  ");
    if (parts.size() != 2) {
      return absl::DataLossError(
          absl::StrCat(path, "/", kDigests, ": not a line \"sha256  file\""));
    }
    const std::string file = JoinPath(path, parts[1]);
    SINEW_ASSIGN_OR_RETURN(std::string content, ReadFile(file));
    const std::string found = Sha256Hex(content);
    if (found != parts[0]) {
      return absl::DataLossError(absl::StrCat(
          file, ": expected SHA-256 ", parts[0], ", found ", found));
    }
    files[parts[1]] = std::move(content);
  }
  return files;
}

absl::StatusOr<Trainer::State> LoadState(const std::string& path) {
  SINEW_ASSIGN_OR_RETURN(auto files, ReadVerified(path));
  Trainer::State state;
  if (!state.counters.ParseFromString(files[kCounters])) {
    return absl::DataLossError(
        absl::StrCat(path, "/", kCounters, ": not a training state"));
  }
  SINEW_ASSIGN_OR_RETURN(
      state.tensors,
      ParseSafetensors(files[kTensors], JoinPath(path, kTensors)));
  for (const v1::SnapshotReference& reference : state.counters.snapshots()) {
    state.snapshots.push_back(files[SnapshotFile(reference.version())]);
  }
  return state;
}

void RemoveFolder(const std::string& path) {
  std::error_code ignored;  // tried again at the next save
  std::filesystem::remove_all(path, ignored);
}

void RemoveOld(const std::string& folder, const std::string& newest, int keep) {
  int whole = 0;
  for (const std::string& name : StateNames(folder)) {
    if (name > newest) continue;
    const std::string path = JoinPath(folder, name);
    const bool is_whole = FileExists(JoinPath(path, kDigests));
    whole += is_whole ? 1 : 0;
    if (!is_whole || whole > keep) RemoveFolder(path);
  }
}

}  // namespace

absl::Status SaveState(const std::string& folder, const Trainer::State& state,
                       int keep) {
  const std::string name =
      absl::StrFormat("%s%08d", kPrefix, state.counters.iteration());
  const std::string path = JoinPath(folder, name);
  if (FileExists(JoinPath(path, kDigests))) return absl::OkStatus();

  std::map<std::string, std::string> files;
  files[kCounters] = SerializeDeterministically(state.counters);
  files[kTensors] = SerializeSafetensors(state.tensors);
  for (int i = 0; i < state.counters.snapshots_size(); ++i) {
    files[SnapshotFile(state.counters.snapshots(i).version())] =
        state.snapshots[i];
  }
  SINEW_RETURN_IF_ERROR(MakeDirectories(path));
  std::string digests;
  absl::Status status;
  for (const auto& [file, content] : files) {
    status.Update(WriteFileAtomically(JoinPath(path, file), content));
    absl::StrAppend(&digests, Sha256Hex(content), "  ", file, "\n");
  }
  if (status.ok()) {
    status = WriteFileAtomically(JoinPath(path, kDigests), digests);
  }
  if (!status.ok()) {
    RemoveFolder(path);
    return status;
  }
  RemoveOld(folder, name, keep);
  return absl::OkStatus();
}

absl::StatusOr<Trainer::State> LoadLatestState(
    const std::string& folder, std::vector<std::string>* warnings) {
  for (const std::string& name : StateNames(folder)) {
    absl::StatusOr<Trainer::State> state = LoadState(JoinPath(folder, name));
    if (state.ok()) return state;
    warnings->push_back(
        absl::StrCat("passed over ", name, ": ", state.status().message()));
  }
  return absl::NotFoundError(absl::StrCat(folder, ": no training state"));
}

}  // namespace sinew::learner
