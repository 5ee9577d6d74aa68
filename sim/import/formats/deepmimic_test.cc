#include "sim/import/formats/deepmimic.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/testing/matchers.h"
#include "sim/import/formats/testing/bad_file.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using ::sinew::testing::EqualsProto;
using ::sinew::testing::IsOk;
using testing::BadFile;

// A frame of the rest pose at a height of 0.9 m that lasts `seconds`.
std::vector<std::string> Row(double seconds) {
  std::vector<std::string> row(kDeepMimicColumns, "0");
  row[0] = absl::StrCat(seconds);
  row[2] = "0.9";
  // Scalar parts: root, chest, neck; hips, ankles and shoulders.
  for (const int w : {4, 8, 12, 16, 21, 25, 30, 35, 39}) row[w] = "1";
  return row;
}

std::string Json(const std::vector<std::vector<std::string>>& rows,
                 const std::string& loop = "none") {
  std::vector<std::string> frames;
  for (const auto& row : rows) {
    frames.push_back(absl::StrCat("[", absl::StrJoin(row, ", "), "]"));
  }
  return absl::StrCat("{\"Loop\": \"", loop, "\", \"Other\": {\"a\": [1]}, ",
                      "\"Frames\": [", absl::StrJoin(frames, ", "), "]}");
}

TEST(DeepMimic, ReadsFramesIntoAWorldWithZUp) {
  std::vector<std::string> row = Row(0.25);
  row[1] = "1";      // forward
  row[3] = "0.5";    // to the right
  row[20] = "-0.7";  // right knee: flexed
  const auto clip =
      ParseDeepMimic(Json({Row(0.25), row, Row(0)}, "wrap"), "c", "c.txt", {});
  ASSERT_THAT(clip, IsOk());
  ASSERT_EQ(clip->poses.size(), 3u);
  EXPECT_TRUE(clip->loops);
  EXPECT_DOUBLE_EQ(clip->duration(), 0.5);
  EXPECT_EQ(clip->poses[1].root_position, Eigen::Vector3d(1, -0.5, 0.9));
  // The flexed shank points back and down from the knee.
  const auto bones = WorldPositions(clip->skeleton, Eigen::Vector3d::Zero(),
                                    clip->poses[1].rotation);
  const Eigen::Vector3d shank = bones[clip->skeleton.Find("right_ankle")] -
                                bones[clip->skeleton.Find("right_knee")];
  EXPECT_LT(shank.x(), -0.2);
  EXPECT_LT(shank.z(), -0.2);
  EXPECT_LT(bones[clip->skeleton.Find("right_hip")].y(), 0) << "y is left";
}

TEST(DeepMimic, NotesHowItWasRead) {
  const auto clip =
      ParseDeepMimic(Json({Row(0.25), Row(0.25), Row(0)}), "c", "c.txt", {});

  ASSERT_THAT(clip, IsOk());
  EXPECT_THAT(clip->facts, EqualsProto(R"pb(
                format: "deepmimic"
                frames_per_second: 4
                duration_s: 0.5
                metres_per_unit: 1
                up_axis: "y"
              )pb"));
}

TEST(DeepMimic, TakesTheUsersRateForItsOwn) {
  const auto clip = ParseDeepMimic(Json({Row(0.25), Row(0.25), Row(0)}), "c",
                                   "c.txt", {.frames_per_second = 20});

  ASSERT_THAT(clip, IsOk());
  EXPECT_DOUBLE_EQ(clip->duration(), 0.1);
  EXPECT_DOUBLE_EQ(clip->facts.frames_per_second(), 20);
}

TEST(DeepMimic, NeedsNoTimesWhereTheUserSaysTheRate) {
  const std::string json = Json({Row(0), Row(0), Row(0)});
  EXPECT_THAT(ParseDeepMimic(json, "c", "dir/c.txt", {}),
              testing::IsRefused("dir/c.txt: ", "duration (column 0)"));
  EXPECT_THAT(ParseDeepMimic(json, "c", "dir/c.txt", {.frames_per_second = 50}),
              IsOk());
  // Too slow for the longest clip, and no rate at all.
  EXPECT_THAT(
      ParseDeepMimic(json, "c", "dir/c.txt", {.frames_per_second = 1e-4}),
      testing::IsRefused("", "frames per second: expected"));
  EXPECT_THAT(
      ParseDeepMimic(Json(std::vector<std::vector<std::string>>(20, Row(0))),
                     "c", "dir/c.txt", {.frames_per_second = 1e-3}),
      testing::IsRefused("dir/c.txt: ",
                         "frame 15: expected at most 14400 seconds"));
}

TEST(DeepMimic, RefusesUnitsAndAxesThatTheFormatHasNot) {
  const std::string json = Json({Row(0.25), Row(0)});
  EXPECT_THAT(ParseDeepMimic(json, "c", "dir/c.txt", {.metres_per_unit = 0.5}),
              testing::IsRefused("dir/c.txt: ", "metres_per_unit: expected 1"));
  EXPECT_THAT(ParseDeepMimic(json, "c", "dir/c.txt", {.up_axis = 'z'}),
              testing::IsRefused("dir/c.txt: ", "up_axis: expected y"));
}

TEST(DeepMimic, NormalisesQuaternionsAndReportsTheDrift) {
  std::vector<std::string> row = Row(0.1);
  row[8] = "1.25";
  const auto clip = ParseDeepMimic(Json({Row(0.1), row}), "c", "c.txt", {});
  ASSERT_THAT(clip, IsOk());
  EXPECT_DOUBLE_EQ(clip->quaternion_drift, 0.25);
  EXPECT_NEAR(clip->poses[1].rotation[1].norm(), 1, 1e-15);
}

class DeepMimicError : public ::testing::TestWithParam<BadFile> {};

TEST_P(DeepMimicError, NamesFileFrameExpectedAndFound) {
  EXPECT_THAT(ParseDeepMimic(GetParam().text, "c", "dir/c.txt", {}),
              testing::IsRefused("dir/c.txt: ", GetParam().expected));
}

std::vector<std::string> With(int column, const std::string& value) {
  std::vector<std::string> row = Row(0.1);
  row[column] = value;
  return row;
}
std::vector<std::string> Short() {
  std::vector<std::string> row = Row(0.1);
  row.pop_back();
  return row;
}

INSTANTIATE_TEST_SUITE_P(
    Files, DeepMimicError,
    ::testing::Values(
        BadFile{"", "expected JSON"}, BadFile{"walk", "expected JSON"},
        BadFile{"[1, 2]", "expected an object, found an array"},
        BadFile{"{}", "expected a key \"Frames\", found none"},
        BadFile{"{\"Frames\": 7}", "\"Frames\": expected an array, found"},
        BadFile{"{\"Frames\": [7, 8]}", "expected an array of numbers"},
        BadFile{Json({Row(0.1)}).substr(0, 60), "expected JSON"},
        BadFile{Json({}), "expected at least 2 frames, found 0"},
        BadFile{Json({Row(0.1)}), "expected at least 2 frames, found 1"},
        BadFile{Json({Row(0.1), Row(0.1)}, "often"),
                "\"Loop\": expected \"wrap\" or \"none\", found \"often\""}));

INSTANTIATE_TEST_SUITE_P(
    Values, DeepMimicError,
    ::testing::Values(
        BadFile{Json({Row(1), Row(1e-300), Row(0)}),
                "frame 1: duration (column 0): expected at least 0.0001 "
                "seconds, found 1e-300"},
        BadFile{Json({Row(4e-320), Row(1), Row(0)}), "frame 0: duration"},
        BadFile{Json({Row(0.1), With(3, "1e7")}),
                "frame 1: column 3: expected a number within +-1e+06, found "
                "1e+07"},
        BadFile{Json({With(20, "-1e300"), Row(0.1)}), "frame 0: column 20"},
        BadFile{Json({Row(0.1), Short()}),
                "frame 1: expected 44 columns, found 43"},
        BadFile{Json({Row(0.1), With(7, "NaN")}),
                "expected finite numbers, found \"N"},
        BadFile{Json({Row(0.1), With(7, "1e999")}), "expected finite numbers"},
        BadFile{Json({Row(0.1), With(7, "\"x\"")}),
                "expected a number, found a string in frame 1"},
        BadFile{Json({With(0, "-0.1"), Row(0.1)}),
                "frame 0: duration (column 0): expected at least 0.0001 "
                "seconds, found -0.1"},
        BadFile{Json({Row(0.1), With(0, "-1")}), "frame 1: duration"},
        BadFile{Json({With(0, "0"), Row(0.1)}), "frame 0: duration"},
        BadFile{Json({Row(0.1), With(16, "3")}),
                "frame 1: rotation of right_hip (columns 16 to 19): expected "
                "a unit quaternion (norm 1 +- 0.5), found norm 3"},
        BadFile{Json({With(0, "1e9"), Row(0.1)}), "seconds, found"}));

TEST(DeepMimic, AnyTruncationIsAnErrorAndNotACrash) {
  const std::string json = Json({Row(0.1), Row(0.1)});
  for (size_t size = 0; size < json.size(); ++size) {
    EXPECT_FALSE(ParseDeepMimic(json.substr(0, size), "c", "c.txt", {}).ok());
  }
}

}  // namespace
}  // namespace sinew::import
