#include "common/config/message_differences.h"

#include "absl/strings/str_replace.h"
#include "absl/strings/strip.h"
#include "common/check.h"
#include "google/protobuf/util/message_differencer.h"

namespace sinew {

std::string MessageDifferences(const google::protobuf::Message& expected,
                               const google::protobuf::Message& found) {
  SINEW_CHECK(expected.GetDescriptor() == found.GetDescriptor());
  std::string differences;
  google::protobuf::util::MessageDifferencer differencer;
  differencer.ReportDifferencesToString(&differences);
  if (differencer.Compare(expected, found)) return "";
  return absl::StrReplaceAll(absl::StripSuffix(differences, "\n"),
                             {{"\n", "; "}});
}

}  // namespace sinew
