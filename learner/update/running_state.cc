#include "learner/update/running_state.h"

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/types/span.h"
#include "common/status_macros.h"

namespace sinew::learner {
namespace {

constexpr char kSumsMean[] = "normaliser_sums/mean";
constexpr char kSumsSquares[] = "normaliser_sums/squares";
constexpr char kFactors[] = "factors";  // std, learning rate

// A float64 tensor of that length; valid as long as `tensors`.
absl::StatusOr<absl::Span<const double>> SavedDoubles(const TensorMap& tensors,
                                                      const std::string& name,
                                                      int64_t length) {
  const std::vector<int64_t> shape = {length};
  const auto found = tensors.find(name);
  if (found == tensors.end() || found->second.dtype != v1::DATA_TYPE_FLOAT64 ||
      found->second.shape != shape) {
    return absl::InvalidArgumentError(absl::StrCat(
        "training state: tensor ", name, ": expected float64 [", length,
        "], found ",
        found == tensors.end()
            ? "none"
            : absl::StrCat(v1::DataType_Name(found->second.dtype), " [",
                           absl::StrJoin(found->second.shape, ", "), "]")));
  }
  return found->second.float64();
}

}  // namespace

void SaveRunningState(const RunningState& state, TensorMap& tensors) {
  const Moments& moments = state.moments;
  const int64_t width = static_cast<int64_t>(moments.mean.size());
  tensors[kSumsMean] = HostTensor::Float64({width}, moments.mean);
  tensors[kSumsSquares] = HostTensor::Float64({width}, moments.squares);
  tensors[kFactors] =
      HostTensor::Float64({2}, {state.std_factor, state.learning_rate_factor});
}

absl::StatusOr<RunningState> LoadRunningState(const TensorMap& tensors,
                                              int64_t width, double count) {
  SINEW_ASSIGN_OR_RETURN(const auto mean,
                         SavedDoubles(tensors, kSumsMean, width));
  SINEW_ASSIGN_OR_RETURN(const auto squares,
                         SavedDoubles(tensors, kSumsSquares, width));
  SINEW_ASSIGN_OR_RETURN(const auto factors,
                         SavedDoubles(tensors, kFactors, 2));
  RunningState state;
  state.moments.count = count;
  state.moments.mean.assign(mean.begin(), mean.end());
  state.moments.squares.assign(squares.begin(), squares.end());
  state.std_factor = factors[0];
  state.learning_rate_factor = factors[1];
  return state;
}

}  // namespace sinew::learner
