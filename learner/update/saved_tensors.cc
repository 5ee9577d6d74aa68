#include "learner/update/saved_tensors.h"

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"

namespace sinew::learner {

absl::StatusOr<absl::Span<const double>> SavedDoubles(
    const TensorMap& tensors, const std::string& name,
    const std::vector<int64_t>& shape) {
  const auto found = tensors.find(name);
  if (found == tensors.end() || found->second.dtype != v1::DATA_TYPE_FLOAT64 ||
      found->second.shape != shape) {
    return absl::InvalidArgumentError(absl::StrCat(
        "training state: tensor ", name, ": expected float64 [",
        absl::StrJoin(shape, ", "), "], found ",
        found == tensors.end()
            ? "none"
            : absl::StrCat(v1::DataType_Name(found->second.dtype), " [",
                           absl::StrJoin(found->second.shape, ", "), "]")));
  }
  return found->second.float64();
}

}  // namespace sinew::learner
