#include "common/testing/matchers.h"

#include <string>

#include "absl/strings/string_view.h"
#include "google/protobuf/message.h"
#include "google/protobuf/text_format.h"
#include "google/protobuf/util/message_differencer.h"
#include "gtest/gtest.h"

namespace sinew::testing::internal {

std::string DifferenceOf(const google::protobuf::Message& actual,
                         const google::protobuf::Message& expected) {
  if (actual.GetDescriptor() != expected.GetDescriptor()) {
    return "which is a " + actual.GetTypeName() + ", expected a " +
           expected.GetTypeName();
  }
  std::string difference;
  google::protobuf::util::MessageDifferencer differencer;
  differencer.ReportDifferencesToString(&difference);
  if (differencer.Compare(expected, actual)) return "";
  return "with the difference (expected -> actual):\n" + difference;
}

void ParseTextOrFail(absl::string_view text,
                     google::protobuf::Message& message) {
  if (!google::protobuf::TextFormat::ParseFromString(std::string(text),
                                                     &message)) {
    ADD_FAILURE() << "EqualsProto: not a text form of " << message.GetTypeName()
                  << ": " << text;
  }
}

}  // namespace sinew::testing::internal
