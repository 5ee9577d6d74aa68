#ifndef SINEW_COMMON_POLICY_GRAPH_ERROR_H_
#define SINEW_COMMON_POLICY_GRAPH_ERROR_H_

#include <string>

#include "absl/status/status.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace sinew::policy::internal {

// INVALID_ARGUMENT with a message made of parts.
template <typename... Parts>
absl::Status Bad(const Parts&... parts) {
  return absl::InvalidArgumentError(absl::StrCat(parts...));
}

// The same error, its message preceded by a place; OK stays OK.
inline absl::Status At(absl::string_view where, const absl::Status& status) {
  if (status.ok()) return status;
  return absl::Status(status.code(),
                      absl::StrCat(where, ": ", status.message()));
}

// A name from outside, fit for a message.
inline std::string Quoted(absl::string_view name) {
  return absl::StrCat("\"", absl::CHexEscape(name.substr(0, 80)), "\"");
}

}  // namespace sinew::policy::internal

#endif  // SINEW_COMMON_POLICY_GRAPH_ERROR_H_
