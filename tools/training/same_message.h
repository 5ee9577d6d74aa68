#ifndef SINEW_TOOLS_TRAINING_SAME_MESSAGE_H_
#define SINEW_TOOLS_TRAINING_SAME_MESSAGE_H_

#include <type_traits>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "google/protobuf/message.h"

namespace sinew::tools {

// Refusals of bundles that do not fit a run. Pure functions; INVALID_ARGUMENT.

// "FIELD: expected EXPECTED, found FOUND".
absl::Status Unfit(absl::string_view field, absl::string_view expected,
                   absl::string_view found);

// Whether both are equal: numbers or texts.
template <typename T>
absl::Status SameValue(absl::string_view field, const T& expected,
                       const std::type_identity_t<T>& found) {
  if (expected == found) return absl::OkStatus();
  return Unfit(field, absl::StrCat(expected), absl::StrCat(found));
}

// Whether both are equal; `expected` is the recipe's.
absl::Status SameMessage(absl::string_view field,
                         const google::protobuf::Message& expected,
                         const google::protobuf::Message& found);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_SAME_MESSAGE_H_
