#include "sim/import/formats/robot_csv.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "common/testing/matchers.h"
#include "sim/import/formats/robot_layout.h"
#include "sim/import/formats/testing/bad_file.h"
#include "sim/import/formats/testing/check_clip.h"
#include "sim/import/formats/testing/recordings.h"

namespace sinew::import {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using testing::BadFile;
using testing::CheckClip;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

v1::RobotLayout Layout(const std::string& name,
                       const std::vector<std::string>& joints,
                       double rate = 0) {
  v1::RobotLayout layout;
  layout.set_name(name);
  for (const std::string& joint : joints) layout.add_joints(joint);
  layout.set_frames_per_second(rate);
  return layout;
}

std::vector<v1::RobotLayout> Layouts() {
  return {Layout("big", {"hip_joint", "knee_joint", "toe_joint"}, 50),
          Layout("small", {"hip_joint", "knee_joint"})};
}

absl::StatusOr<RobotClip> Parse(const std::string& text,
                                const ReadOptions& options = {}) {
  return ParseRobotCsv(text, "step", "dir/step.csv", options, Layouts());
}

// Columns in the order x, y, z, w.
constexpr char kTwoRows[] =
    "1,2,0.8,0,0,0.6,0.8,0.1,0.2\n"
    "1.5,2,0.8,0,0,0.6,0.8,0.3,0.4\n";

TEST(RobotCsv, ReadsRowsOfTheOnlyLayoutThatFits) {
  const auto clip =
      Parse(kTwoRows, {.frames_per_second = 10, .quaternion_order = "xyzw"});

  ASSERT_THAT(clip, IsOk());
  CheckClip(*clip);
  EXPECT_THAT(clip->joints, ElementsAre("hip_joint", "knee_joint"));
  EXPECT_EQ(clip->facts.format(), "robot_csv");
  EXPECT_EQ(clip->facts.map(), "small");
  EXPECT_EQ(clip->facts.quaternion_order(), "xyzw");
  EXPECT_THAT(clip->facts.concluded(), IsEmpty());
  EXPECT_THAT(clip->warnings, IsEmpty());
  EXPECT_DOUBLE_EQ(clip->duration(), 0.1);
  EXPECT_EQ(clip->poses[1].root_position, Eigen::Vector3d(1.5, 2, 0.8));
  EXPECT_EQ(clip->poses[1].joints, Eigen::Vector2d(0.3, 0.4));
  EXPECT_DOUBLE_EQ(clip->poses[1].root_rotation.w(), 0.8);
  EXPECT_DOUBLE_EQ(clip->poses[1].root_rotation.z(), 0.6);
}

TEST(RobotCsv, SpacesTabsAndSemicolonsPartColumnsToo) {
  const auto commas = Parse(kTwoRows);
  ASSERT_THAT(commas, IsOk());
  for (const char* separator : {" ", "\t", ";", " , ", "   "}) {
    const auto clip = Parse(absl::StrReplaceAll(kTwoRows, {{",", separator}}));
    ASSERT_THAT(clip, IsOk()) << "\"" << separator << "\"";
    EXPECT_EQ(clip->poses[1].joints, commas->poses[1].joints);
  }
}

TEST(RobotCsv, EndsOfLinesByWindowsAndEmptyLinesDoNotMatter) {
  const auto clip = Parse(absl::StrCat(
      "\xEF\xBB\xBF", absl::StrReplaceAll(kTwoRows, {{"\n", ",\r\n\r\n"}})));

  ASSERT_THAT(clip, IsOk());
  EXPECT_EQ(clip->poses.size(), 2u);
}

TEST(RobotCsv, KeepsTheColumnsOfQuaternionsWhoseOrderNobodySays) {
  const auto clip = Parse(kTwoRows);

  ASSERT_THAT(clip, IsOk());
  EXPECT_EQ(clip->facts.quaternion_order(), "");
  EXPECT_DOUBLE_EQ(clip->poses[0].root_rotation.y(), 0.6);
  EXPECT_DOUBLE_EQ(clip->poses[0].root_rotation.z(), 0.8);
}

TEST(RobotCsv, SaysWhereTheRateComesFrom) {
  const auto by_default = Parse(kTwoRows);
  ASSERT_THAT(by_default, IsOk());
  EXPECT_DOUBLE_EQ(by_default->facts.frames_per_second(), kDefaultRobotRate);
  EXPECT_THAT(by_default->facts.concluded(), ElementsAre("frames_per_second"));
  EXPECT_THAT(by_default->warnings,
              ElementsAre("the file says no frame rate; read at 30 frames per "
                          "second, the default"));

  const auto by_layout = Parse("0 0 1 1 0 0 0 1 2 3\n0 0 1 1 0 0 0 1 2 3\n");
  ASSERT_THAT(by_layout, IsOk());
  EXPECT_DOUBLE_EQ(by_layout->facts.frames_per_second(), 50);
  EXPECT_THAT(by_layout->warnings, ElementsAre(HasSubstr("as big says")));
}

TEST(RobotCsv, TakesJointsAndQuaternionOrderFromNamedColumns) {
  const auto clip = Parse(absl::StrCat(
      "# x,y,z,root_qw,root_qx,root_qy,root_qz,toe_joint_dof,\"hip\"\n",
      "0,0,1,0.8,0,0,0.6,1,2\n0,0,1,0.8,0,0,0.6,1,2\n"));

  ASSERT_THAT(clip, IsOk());
  EXPECT_EQ(clip->facts.map(), "big");
  EXPECT_EQ(clip->facts.quaternion_order(), "wxyz");
  EXPECT_THAT(clip->joints, ElementsAre("toe_joint", "hip_joint"));
}

TEST(RobotCsv, NamesThatMeanNothingLeaveTheOrderOfTheLayout) {
  const auto clip = Parse(absl::StrCat("a,b,c,d,e,f,g,h,i\n", kTwoRows));

  ASSERT_THAT(clip, IsOk());
  EXPECT_EQ(clip->facts.map(), "small");
  EXPECT_THAT(clip->warnings,
              ::testing::Contains(HasSubstr("names no joint that is known")));
}

class RobotCsvError : public ::testing::TestWithParam<BadFile> {};

TEST_P(RobotCsvError, NamesFileLineExpectedAndFound) {
  EXPECT_THAT(Parse(GetParam().text),
              testing::IsRefused("dir/step.csv: ", GetParam().expected));
}

constexpr char kRow[] = "0,0,1,1,0,0,0,0,0\n";

INSTANTIATE_TEST_SUITE_P(
    Files, RobotCsvError,
    ::testing::Values(
        BadFile{"", "expected lines of numbers, found none"},
        BadFile{"x,y,z\n", "expected lines of numbers, found none"},
        BadFile{kRow, "expected at least 2 frames, found 1"},
        BadFile{"0,0,1,1,0,0,0\n0,0,1,1,0,0,0\n",
                "expected 7 columns of the root and those of one layout (big: "
                "3 joints, small: 2 joints), found 7 columns"},
        BadFile{"1 2 3\n", "found 3 columns"},
        BadFile{"a,b,c,d,e,f,g,hip,tail\n0,0,1,1,0,0,0,0,0\n",
                "found a column \"tail\""},
        BadFile{"a,b,c,d,e,f,g,hip,hip_joint\n0,0,1,1,0,0,0,0,0\n",
                "found a joint twice"},
        BadFile{std::string(70000, '1'),
                "line 1: expected at most 65536 bytes, found 70000"},
        BadFile{std::string("\x00\xFF\x00\x01", 4), "expected lines"}));

INSTANTIATE_TEST_SUITE_P(
    Rows, RobotCsvError,
    ::testing::Values(
        BadFile{absl::StrCat(kRow, "0,0,1,1,0,0,0,0\n"),
                "line 2: expected 9 columns as in line 1, found 8"},
        BadFile{absl::StrCat(kRow, "0,0,nan,1,0,0,0,0,0\n"),
                "line 2, column 3: expected a finite number, found \"nan\""},
        BadFile{absl::StrCat(kRow, "0,0,1e999,1,0,0,0,0,0\n"),
                "expected a finite number, found \"1e999\""},
        BadFile{absl::StrCat(kRow, "0,0,,1,0,0,0,0,0\n"),
                "expected a finite number, found \"\""},
        BadFile{absl::StrCat(kRow, "0,0,1e7,1,0,0,0,0,0\n"),
                "line 2, column 3: expected m within +-1e+06, found 1e+07"},
        BadFile{absl::StrCat(kRow, "0,0,1,1,0,0,0,0,9999\n"),
                "line 2, column 9: expected rad within +-1000, found 9999"},
        BadFile{absl::StrCat(kRow, "0,0,1,0.5,0.5,0.5,0.6,0,0\n"),
                "line 2, columns 4 to 7: expected a unit quaternion (norm 1 "
                "+- 0.01), found norm 1.05"}));

TEST(RobotCsv, RefusesAmbiguousColumns) {
  std::vector<v1::RobotLayout> layouts = Layouts();
  layouts.push_back(Layout("other", {"a", "b"}));

  EXPECT_THAT(ParseRobotCsv(kTwoRows, "c", "c.csv", {}, layouts),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("found 9 columns, as of small and other")));
}

TEST(RobotCsv, RefusesLongClipsAndOtherAxes) {
  EXPECT_THAT(Parse(kTwoRows, {.frames_per_second = 5e-3}), IsOk());
  EXPECT_THAT(
      Parse(absl::StrCat(kTwoRows, kTwoRows, kTwoRows, kTwoRows, kTwoRows,
                         kTwoRows, kTwoRows, kTwoRows),
            {.frames_per_second = 1e-3}),
      StatusIs(absl::StatusCode::kResourceExhausted,
               HasSubstr("expected at most 14400 seconds, found 15000")));
  EXPECT_THAT(Parse(kTwoRows, {.up_axis = 'y'}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("up_axis: expected z for a robot, found y")));
}

TEST(RobotLayouts, ThoseThatComeWithSinewCanBeToldApartByTheirColumns) {
  const auto layouts = KnownRobotLayouts();

  ASSERT_THAT(layouts, IsOk());
  std::vector<std::string> counts;
  for (const v1::RobotLayout& layout : *layouts) {
    counts.push_back(absl::StrCat(layout.name(), " ", layout.joints_size()));
  }
  EXPECT_THAT(counts, ElementsAre("g1_23dof 23", "g1_29dof 29", "h1_2 27"));
}

TEST(RobotLayouts, ErrorsNameFieldExpectedAndFound) {
  const auto expect = [](const std::string& text, const std::string& message) {
    EXPECT_THAT(ParseRobotLayout(text, "my.textproto"),
                StatusIs(absl::StatusCode::kInvalidArgument,
                         AllOf(HasSubstr("my.textproto"), HasSubstr(message))));
  };
  expect("joints: \"a\"", "name: expected [a-z0-9_]+, found \"\"");
  expect("name: \"My robot\" joints: \"a\"", "found \"My robot\"");
  expect("name: \"r\"", "joints: expected 1 to 500, found 0");
  expect("name: \"r\" joints: \"a\" joints: \"a\"", "found \"a\" twice");
  expect("name: \"r\" joints: \"a\" frames_per_second: -1",
         "frames_per_second: expected 0 to 10000, found -1");
  expect("nam: \"r\"", "nam");
}

TEST(RobotCsv, ReadsEveryRealRecording) {
  const auto layouts = KnownRobotLayouts();
  ASSERT_THAT(layouts, IsOk());
  int read = 0;
  for (const char* place :
       {"motions/g1_moves/csv", "motions/asap/g1_csv_converted"}) {
    const bool is_asap = absl::StrContains(place, "asap");
    const auto recordings = testing::Recordings(place, ".csv");
    if (recordings.empty()) GTEST_SKIP() << "SINEW_DATA is not set";
    for (const auto& [name, text] : recordings) {
      const auto clip = ParseRobotCsv(text, name, name, {}, *layouts);
      ASSERT_THAT(clip, IsOk());
      CheckClip(*clip);
      EXPECT_EQ(clip->facts.map(), is_asap ? "g1_23dof" : "g1_29dof");
      EXPECT_EQ(clip->facts.frames_per_second(), is_asap ? 30 : 60);
      ++read;
    }
  }
  EXPECT_GE(read, 90);
}

}  // namespace
}  // namespace sinew::import
