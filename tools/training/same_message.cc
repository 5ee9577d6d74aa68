#include "tools/training/same_message.h"

#include <google/protobuf/util/message_differencer.h>

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"

namespace sinew::tools {

absl::Status Unfit(absl::string_view field, absl::string_view expected,
                   absl::string_view found) {
  return absl::InvalidArgumentError(
      absl::StrCat(field, ": expected ", expected, ", found ", found));
}

absl::Status SameMessage(absl::string_view field,
                         const google::protobuf::Message& expected,
                         const google::protobuf::Message& found) {
  google::protobuf::util::MessageDifferencer differencer;
  std::string differences;
  differencer.ReportDifferencesToString(&differences);
  if (differencer.Compare(expected, found)) return absl::OkStatus();
  std::replace(differences.begin(), differences.end(), '\n', ' ');
  return Unfit(
      field, "the recipe's",
      absl::StrCat("another (", absl::StripSuffix(differences, " "), ")"));
}

absl::Status In(absl::string_view source, const absl::Status& status) {
  if (status.ok()) return status;
  return absl::Status(status.code(),
                      absl::StrCat(source, ": ", status.message()));
}

}  // namespace sinew::tools
