#include "learner/memory/memory_chunk.h"

#include <cmath>
#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/string_view.h"
#include "common/check.h"
#include "common/digest.h"
#include "common/policy/safetensors.h"
#include "common/status_macros.h"

namespace sinew::learner {
namespace {

constexpr char kObservation[] = "observation";
constexpr char kLabel[] = "label";
constexpr char kValid[] = "valid";
constexpr char kLinked[] = "linked";

absl::Status Damaged(const StateChunk& chunk, absl::string_view what,
                     absl::string_view expected, absl::string_view found) {
  return absl::DataLossError(absl::StrCat("memory-", chunk.sha256, ": ", what,
                                          ": expected ", expected, ", found ",
                                          found));
}

std::string ShapeText(absl::Span<const int64_t> shape) {
  return absl::StrCat("float32 [", absl::StrJoin(shape, ", "), "]");
}

absl::StatusOr<absl::Span<const float>> Array(
    const StateChunk& chunk, const SafetensorsView& file,
    const std::string& name, const std::vector<int64_t>& shape) {
  const auto found = file.tensors.find(name);
  if (found == file.tensors.end()) {
    return Damaged(chunk, name, ShapeText(shape), "none");
  }
  const TensorView& tensor = found->second;
  if (tensor.dtype != v1::DATA_TYPE_FLOAT32 || tensor.shape != shape) {
    return Damaged(chunk, name, ShapeText(shape),
                   absl::StrCat(v1::DataType_Name(tensor.dtype), " [",
                                absl::StrJoin(tensor.shape, ", "), "]"));
  }
  if (!tensor.aligned()) {
    return Damaged(chunk, name, "data at a multiple of 4 bytes", "another");
  }
  for (const float value : tensor.float32()) {
    if (std::isfinite(value)) continue;
    return Damaged(chunk, name, "finite numbers", absl::StrCat(value));
  }
  return tensor.float32();
}

absl::Status CheckFlags(const StateChunk& chunk, const SequencesView& view,
                        int64_t steps) {
  for (const auto& [name, flags] :
       {std::pair{kValid, view.valid}, std::pair{kLinked, view.linked}}) {
    for (const float flag : flags) {
      if (flag == 0 || flag == 1) continue;
      return Damaged(chunk, name, "flags of 0 or 1", absl::StrCat(flag));
    }
  }
  for (size_t i = 0; i < view.linked.size(); ++i) {
    if (view.linked[i] == 0) continue;
    const bool first = static_cast<int64_t>(i) % steps == 0;
    if (!first && view.valid[i] == 1 && view.valid[i - 1] == 1) continue;
    return Damaged(chunk, kLinked, "links between valid rows of a sequence",
                   absl::StrCat("another at row ", i));
  }
  return absl::OkStatus();
}

// The number of sequences, as the flags have it.
absl::StatusOr<int64_t> CountSequences(const StateChunk& chunk,
                                       const SafetensorsView& file,
                                       const SequenceShape& shape) {
  const auto valid = file.tensors.find(kValid);
  if (valid == file.tensors.end() || valid->second.shape.size() != 2 ||
      valid->second.shape[0] < 1) {
    return Damaged(chunk, kValid,
                   absl::StrCat("float32 [E >= 1, ", shape.steps, "]"),
                   valid == file.tensors.end() ? "none" : "another shape");
  }
  return valid->second.shape[0];
}

}  // namespace

StateChunk MakeChunk(const LabelledSequences& sequences,
                     const SequenceShape& shape) {
  const int64_t rows = static_cast<int64_t>(sequences.valid.size());
  SINEW_CHECK(rows > 0 && rows % shape.steps == 0 &&
              sequences.linked.size() == sequences.valid.size())
      << rows << " rows of sequences of " << shape.steps;
  const int64_t count = rows / shape.steps;
  const TensorMap tensors = {
      {kObservation,
       HostTensor::Float32({count, shape.steps, shape.observation},
                           sequences.observation)},
      {kLabel, HostTensor::Float32({count, shape.steps, shape.action},
                                   sequences.label)},
      {kValid, HostTensor::Float32({count, shape.steps}, sequences.valid)},
      {kLinked, HostTensor::Float32({count, shape.steps}, sequences.linked)}};
  auto bytes = std::make_shared<const std::string>(SerializeSafetensors(
      tensors, {{"order_id", absl::StrCat(sequences.order_id)}}));
  StateChunk chunk;
  chunk.sha256 = Sha256Hex(*bytes);
  chunk.bytes = std::move(bytes);
  return chunk;
}

absl::StatusOr<SequencesView> ViewChunk(const StateChunk& chunk,
                                        const SequenceShape& shape) {
  const std::string found = Sha256Hex(*chunk.bytes);
  if (found != chunk.sha256) {
    return Damaged(chunk, "SHA-256", chunk.sha256, found);
  }
  return ViewOwnChunk(chunk, shape);
}

absl::StatusOr<SequencesView> ViewOwnChunk(const StateChunk& chunk,
                                           const SequenceShape& shape) {
  absl::StatusOr<SafetensorsView> file =
      ViewSafetensors(*chunk.bytes, absl::StrCat("memory-", chunk.sha256));
  if (!file.ok()) return absl::DataLossError(file.status().message());
  SINEW_ASSIGN_OR_RETURN(const int64_t count,
                         CountSequences(chunk, *file, shape));
  SequencesView view;
  view.sequences = count;
  SINEW_ASSIGN_OR_RETURN(view.observation,
                         Array(chunk, *file, kObservation,
                               {count, shape.steps, shape.observation}));
  SINEW_ASSIGN_OR_RETURN(view.label, Array(chunk, *file, kLabel,
                                           {count, shape.steps, shape.action}));
  SINEW_ASSIGN_OR_RETURN(view.valid,
                         Array(chunk, *file, kValid, {count, shape.steps}));
  SINEW_ASSIGN_OR_RETURN(view.linked,
                         Array(chunk, *file, kLinked, {count, shape.steps}));
  SINEW_RETURN_IF_ERROR(CheckFlags(chunk, view, shape.steps));
  return view;
}

}  // namespace sinew::learner
