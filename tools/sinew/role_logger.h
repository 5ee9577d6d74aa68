#ifndef SINEW_TOOLS_SINEW_ROLE_LOGGER_H_
#define SINEW_TOOLS_SINEW_ROLE_LOGGER_H_

#include <string>

#include "absl/status/status.h"

namespace sinew::tools {

// From now on lines of this program's log say that they are an "actor"'s, a
// "replay"'s ...: the logs of a run's servers are read together. Errors: none
// in practice.
absl::Status LogAs(const std::string& role);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_ROLE_LOGGER_H_
