#ifndef SINEW_LEARNER_UPDATE_SAVED_TENSORS_H_
#define SINEW_LEARNER_UPDATE_SAVED_TENSORS_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "common/policy/safetensors.h"

namespace sinew::learner {

// A saved float64 tensor of that shape; valid as long as `tensors`.
// INVALID_ARGUMENT names it, expected and found. Pure.
absl::StatusOr<absl::Span<const double>> SavedDoubles(
    const TensorMap& tensors, const std::string& name,
    const std::vector<int64_t>& shape);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_UPDATE_SAVED_TENSORS_H_
