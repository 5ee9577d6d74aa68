#include "common/config/text_proto.h"

#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew {
namespace {

using ::sinew::testing::EqualsProto;
using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

absl::Status Parse(absl::string_view text) {
  v1::Recipe recipe;
  return ParseTextProto(text, "walk.textproto", recipe);
}

TEST(ParseTextProto, ReadsAMessage) {
  v1::Recipe recipe;
  recipe.set_seed(9);

  ASSERT_THAT(ParseTextProto("# note\nname: \"walk\"\nppo { epochs: 3 }",
                             "walk.textproto", recipe),
              IsOk());

  EXPECT_THAT(recipe, EqualsProto("name: 'walk' ppo { epochs: 3 }"));
}

TEST(ParseTextProto, NamesFileLineColumnAndUnknownField) {
  EXPECT_THAT(
      Parse("name: \"walk\"\nppo {\n  epoch: 3\n}\n"),
      StatusIs(absl::StatusCode::kInvalidArgument,
               "walk.textproto:3:8: Message type \"sinew.v1.Ppo\" has no field "
               "named \"epoch\". The nearest is \"epochs\" in: epoch: 3"));
}

TEST(ParseTextProto, ShowsTheFieldOfAValueOfTheWrongType) {
  EXPECT_THAT(Parse("ppo {\n  epochs: many\n}"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "walk.textproto:2:11: Expected integer, got: many in: "
                       "epochs: many"));
}

TEST(ParseTextProto, RefusesAValueOutOfTheTypesRange) {
  EXPECT_THAT(Parse("ppo { epochs: 3000000000 }"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("walk.textproto:1:15: Integer out of range")));
}

TEST(ParseTextProto, RefusesAnUnknownEnumValue) {
  EXPECT_THAT(Parse("task { start { rule: RULE_NEWEST } }"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("\"RULE_NEWEST\" for field \"rule\"")));
}

TEST(ParseTextProto, RefusesAFieldGivenTwice) {
  EXPECT_THAT(Parse("seed: 1\nseed: 2"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("walk.textproto:2:")));
}

TEST(ParseTextProto, RefusesTextThatEndsInTheMiddle) {
  EXPECT_THAT(Parse("ppo {\n  epochs: 3\n"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("walk.textproto:3:1: ")));
}

TEST(ParseTextProto, ShowsOnlyTheBeginningOfALongLine) {
  const absl::Status status = Parse(
      absl::StrCat("name: \"", std::string(100000, 'x'), "\" nothing: 1"));

  EXPECT_THAT(status, StatusIs(absl::StatusCode::kInvalidArgument));
  EXPECT_LT(status.message().size(), 300u);
}

TEST(ParseTextProto, SurvivesDeepNestingAndBytesThatAreNoText) {
  std::string deep;
  for (int i = 0; i < 100000; ++i) absl::StrAppend(&deep, "ppo {");

  EXPECT_THAT(Parse(deep), StatusIs(absl::StatusCode::kInvalidArgument));
  EXPECT_THAT(Parse(absl::string_view("\x00\xff\x01{", 4)),
              StatusIs(absl::StatusCode::kInvalidArgument));
}

TEST(ParseTextProto, RefusesMoreTextThanTheBound) {
  EXPECT_THAT(Parse(std::string(64 << 20, ' ')),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "walk.textproto: expected less than 67108864 bytes of "
                       "text, found 67108864"));
}

}  // namespace
}  // namespace sinew
