#ifndef SINEW_COMMON_POLICY_VALIDATE_TAPS_H_
#define SINEW_COMMON_POLICY_VALIDATE_TAPS_H_

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "proto/sinew/v1/graph.pb.h"

namespace sinew::policy::internal {

// The names that a graph may have (validate.h).
absl::Status CheckName(absl::string_view name);

// Checks the taps of a graph whose values have these widths, against the
// shapes of all parameters. INVALID_ARGUMENT names the tap.
absl::Status CheckTaps(
    const v1::Graph& graph,
    const std::map<std::string, std::vector<int64_t>>& shapes,
    const std::map<std::string, int64_t>& widths);

}  // namespace sinew::policy::internal

#endif  // SINEW_COMMON_POLICY_VALIDATE_TAPS_H_
