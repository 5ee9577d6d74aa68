#include "tools/training/same_message.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "common/config/message_differences.h"

namespace sinew::tools {

absl::Status Unfit(absl::string_view field, absl::string_view expected,
                   absl::string_view found) {
  return absl::InvalidArgumentError(
      absl::StrCat(field, ": expected ", expected, ", found ", found));
}

absl::Status SameMessage(absl::string_view field,
                         const google::protobuf::Message& expected,
                         const google::protobuf::Message& found) {
  const std::string differences = MessageDifferences(expected, found);
  if (differences.empty()) return absl::OkStatus();
  return Unfit(field, "the recipe's",
               absl::StrCat("another (", differences, ")"));
}

}  // namespace sinew::tools
