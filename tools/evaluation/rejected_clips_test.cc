#include "tools/evaluation/rejected_clips.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

#include "common/testing/test_files.h"

namespace sinew::evaluation {
namespace {

using ::sinew::testing::TestPath;
using ::sinew::testing::WriteTestFile;

TEST(RejectedClips, AreThoseThatWereMeasuredAndTurnedAway) {
  WriteTestFile("library/report.json", R"({"clips": [
    {"name": "walk", "status": "ok", "frames": 30},
    {"name": "run", "status": "warned", "frames": 30},
    {"name": "fly", "status": "rejected", "frames": 30, "reason": "no floor"},
    {"name": "readme", "status": "rejected"}]})");

  const std::vector<RejectedClip> expected = {{"fly", "no floor"}};
  EXPECT_EQ(RejectedClips(TestPath("library"), 2), expected);
}

TEST(RejectedClips, AreUnknownWithoutAReportOfThisLibrary) {
  EXPECT_EQ(RejectedClips(TestPath("nowhere"), 2), std::nullopt);
  for (const std::string text :
       {"", "[]", "{}", R"({"clips": [3]})",
        R"({"clips": [{"name": "walk", "status": "ok", "frames": 30}]})"}) {
    WriteTestFile("library/report.json", text);

    EXPECT_EQ(RejectedClips(TestPath("library"), 2), std::nullopt) << text;
  }
}

}  // namespace
}  // namespace sinew::evaluation
