#include "tools/evaluation/rejected_clips.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

#include "common/testing/matchers.h"
#include "common/testing/test_files.h"

namespace sinew::evaluation {
namespace {

using ::sinew::testing::IsOkAndHolds;
using ::sinew::testing::StatusIs;
using ::sinew::testing::TestPath;
using ::sinew::testing::WriteTestFile;
using ::testing::HasSubstr;

TEST(RejectedClips, AreThoseThatWereMeasuredAndTurnedAway) {
  WriteTestFile("library/report.json", R"({"clips": [
    {"name": "walk", "status": "ok", "frames": 30},
    {"name": "run", "status": "warned", "frames": 30},
    {"name": "fly", "status": "rejected", "frames": 30, "reason": "no floor"},
    {"name": "readme", "status": "rejected"}]})");

  const std::vector<RejectedClip> expected = {{"fly", "no floor"}};
  EXPECT_THAT(RejectedClips(TestPath("library"), 2), IsOkAndHolds(expected));
}

TEST(RejectedClips, AreUnknownWithoutAReportOfThisLibrary) {
  EXPECT_THAT(RejectedClips(TestPath("nowhere"), 2),
              IsOkAndHolds(std::nullopt));
  WriteTestFile(
      "library/report.json",
      R"({"clips": [{"name": "walk", "status": "ok", "frames": 30}]})");
  EXPECT_THAT(RejectedClips(TestPath("library"), 2),
              IsOkAndHolds(std::nullopt));
}

TEST(RejectedClips, NamesAReportThatIsNone) {
  for (const std::string text :
       {"", "[]", "{}", R"({"clips": 5})", R"({"clips": [3]})"}) {
    const std::string path = WriteTestFile("library/report.json", text);

    EXPECT_THAT(RejectedClips(TestPath("library"), 2),
                StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr(path)))
        << text;
  }
}

}  // namespace
}  // namespace sinew::evaluation
