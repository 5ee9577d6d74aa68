#include "common/json_fields.h"

#include <nlohmann/json.hpp>

#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew {
namespace {

using ::sinew::testing::StatusIs;

TEST(NumberAt, FindsNumbersBelowKeysAndTakesTheOtherwiseForAnythingElse) {
  const auto object = nlohmann::json::parse(
      R"({"seconds": {"learn": 2.5, "name": "x"}, "cores": 3})");

  EXPECT_EQ(NumberAt(object, {"cores"}), 3);
  EXPECT_EQ(NumberAt(object, {"seconds", "learn"}), 2.5);
  EXPECT_EQ(NumberAt(object, {"seconds", "name"}), 0);
  EXPECT_EQ(NumberAt(object, {"seconds", "act"}, -1), -1);
  EXPECT_EQ(NumberAt(object, {"cores", "learn"}, 7), 7);
  EXPECT_EQ(NumberAt(nlohmann::ordered_json(), {"cores"}, 7), 7);
}

TEST(TextAt, FindsTextBelowKeysAndNothingInAnythingElse) {
  const auto object = nlohmann::json::parse(
      R"({"bundle": {"path": "runs/one", "clips": 3}, "name": "x"})");

  EXPECT_EQ(TextAt(object, {"name"}), "x");
  EXPECT_EQ(TextAt(object, {"bundle", "path"}), "runs/one");
  EXPECT_EQ(TextAt(object, {"bundle", "clips"}), "");
  EXPECT_EQ(TextAt(object, {"bundle"}), "");
  EXPECT_EQ(TextAt(object, {"name", "path"}), "");
  EXPECT_EQ(TextAt(nlohmann::ordered_json(), {"name"}), "");
}

TEST(UnfitField, NamesFileAndField) {
  EXPECT_THAT(UnfitField("eval.json", "seconds", "10", "5"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "eval.json: seconds: expected 10, found 5"));
}

}  // namespace
}  // namespace sinew
