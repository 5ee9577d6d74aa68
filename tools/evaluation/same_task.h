#ifndef SINEW_TOOLS_EVALUATION_SAME_TASK_H_
#define SINEW_TOOLS_EVALUATION_SAME_TASK_H_

#include <nlohmann/json.hpp>
#include <string>

#include "absl/status/status.h"

namespace sinew::evaluation {

// Whether two files that `sinew eval` wrote (evaluation_json.h) have asked the
// same of their policies, so that their figures may be compared: the library,
// how many starts of how many seconds, whether they were randomised (not how
// much), and what counts as a fall.
//
// Thread-safety: pure. Blocking: never. Errors: INVALID_ARGUMENT naming `file`,
// the first field that differs, what `first` has and what was found; a field
// that one of them lacks is null.
absl::Status CheckSameTask(const nlohmann::json& first,
                           const nlohmann::json& found,
                           const std::string& file);

}  // namespace sinew::evaluation

#endif  // SINEW_TOOLS_EVALUATION_SAME_TASK_H_
