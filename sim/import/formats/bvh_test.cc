#include "sim/import/formats/bvh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "common/testing/matchers.h"
#include "sim/import/formats/testing/bad_file.h"
#include "sim/import/formats/testing/check_clip.h"
#include "sim/import/formats/testing/made_files.h"

namespace sinew::import {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using testing::BadFile;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180;

// Hips with a foot 1 m below and a head above, two frames, y up, metres.
constexpr char kSmall[] = R"(HIERARCHY
ROOT Hips
{
  OFFSET 0 0.9 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT LeftFoot
  {
    OFFSET 0.1 -1 0
    CHANNELS 3 Yrotation Zrotation Xrotation
    End Site
    {
      OFFSET 0 0 0.2
    }
  }
  JOINT Head
  {
    OFFSET 0 0.6 0
  }
}
MOTION
Frames: 2
Frame Time: 0.04
1 2 3 0 0 0 0 0 0
1 2 3 10 20 30 40 50 60
)";

absl::StatusOr<SourceClip> Parse(const std::string& text,
                                 const ReadOptions& options = {}) {
  absl::StatusOr<SourceClip> clip =
      ParseBvh(text, "clip", "dir/clip.bvh", options);
  if (clip.ok()) testing::CheckClip(*clip);
  return clip;
}

// kSmall with some texts replaced.
std::string Small(
    const std::vector<std::pair<const absl::string_view, std::string>>&
        changes) {
  return absl::StrReplaceAll(kSmall, changes);
}

TEST(Bvh, ReadsSkeletonPosesAndTimes) {
  const auto clip = Parse(kSmall);

  ASSERT_THAT(clip, IsOk());
  EXPECT_EQ(clip->name, "clip");
  ASSERT_THAT(clip->skeleton.joints, SizeIs(4));
  const SourceJoint& end = clip->skeleton.joints[2];
  EXPECT_EQ(end.name, "LeftFoot_end");
  EXPECT_EQ(end.parent, 1);
  EXPECT_TRUE(end.is_end);
  // The file's (x, y, z) are the world's (y, z, x).
  EXPECT_EQ(end.offset, Vector3d(0.2, 0, 0));
  EXPECT_EQ(clip->skeleton.joints[1].offset, Vector3d(0, 0.1, -1));
  EXPECT_EQ(clip->poses[1].root_position, Vector3d(3, 1, 2));
  EXPECT_DOUBLE_EQ(clip->poses[1].time, 0.04);
  EXPECT_THAT(clip->warnings, IsEmpty());
}

TEST(Bvh, TurnsByTheChannelsOfEachJointInItsOwnOrder) {
  const auto clip = Parse(kSmall);

  ASSERT_THAT(clip, IsOk());
  // The file's x, y, z axes are the world's y, z, x.
  const Vector3d x = Vector3d::UnitY();
  const Vector3d y = Vector3d::UnitZ();
  const Vector3d z = Vector3d::UnitX();
  const Quaterniond hips = AngleAxisd(10 * kDegree, z) *
                           AngleAxisd(20 * kDegree, x) *
                           AngleAxisd(30 * kDegree, y);
  const Quaterniond foot = AngleAxisd(40 * kDegree, y) *
                           AngleAxisd(50 * kDegree, z) *
                           AngleAxisd(60 * kDegree, x);
  EXPECT_TRUE(clip->poses[1].rotation[0].isApprox(hips, 1e-12));
  EXPECT_TRUE(clip->poses[1].rotation[1].isApprox(foot, 1e-12));
  EXPECT_TRUE(clip->poses[1].rotation[3].isApprox(Quaterniond::Identity()));
}

TEST(Bvh, ReadsOneAndTwoRotationChannels) {
  const auto clip = Parse(Small(
      {{"CHANNELS 3 Yrotation Zrotation Xrotation", "CHANNELS 1 Xrotation"},
       {"OFFSET 0 0.6 0", "OFFSET 0 0.6 0\nCHANNELS 2 Zrotation Yrotation"}}));

  ASSERT_THAT(clip, IsOk());
  const Quaterniond foot(AngleAxisd(40 * kDegree, Vector3d::UnitY()));
  const Quaterniond head = AngleAxisd(50 * kDegree, Vector3d::UnitX()) *
                           AngleAxisd(60 * kDegree, Vector3d::UnitZ());
  EXPECT_TRUE(clip->poses[1].rotation[1].isApprox(foot, 1e-12));
  EXPECT_TRUE(clip->poses[1].rotation[3].isApprox(head, 1e-12));
}

TEST(Bvh, TakesAnyCaseWhiteSpaceAndLineEnd) {
  const auto plain = Parse(kSmall);
  const auto odd = Parse(
      absl::StrCat("\xef\xbb\xbf", Small({{"HIERARCHY", "hierarchy"},
                                          {"ROOT", "Root"},
                                          {"MOTION", "Motion"},
                                          {"OFFSET", "offset\t"},
                                          {"CHANNELS", "Channels"},
                                          {"Xrotation", "xROTATION"},
                                          {"End Site", "end\tsite"},
                                          {"Frames:", "frames:\t"},
                                          {"Frame Time:", "frame time:\t"},
                                          {"\n{\n", " {"},
                                          {"\n", "\r\n"}})));

  ASSERT_THAT(plain, IsOk());
  ASSERT_THAT(odd, IsOk());
  for (size_t i = 0; i < plain->skeleton.joints.size(); ++i) {
    EXPECT_EQ(odd->skeleton.joints[i].name, plain->skeleton.joints[i].name);
    EXPECT_EQ(odd->poses[1].rotation[i], plain->poses[1].rotation[i]);
  }
}

TEST(Bvh, KeepsNamesWithColonsAndSpaces) {
  const auto clip = Parse(Small({{"LeftFoot", "mixamorig:Left Foot"}}));

  ASSERT_THAT(clip, IsOk());
  EXPECT_EQ(clip->skeleton.joints[1].name, "mixamorig:Left Foot");
  EXPECT_EQ(clip->skeleton.joints[2].name, "mixamorig:Left Foot_end");
}

TEST(Bvh, NumbersJointsOfOneNameWithAWarning) {
  const auto clip = Parse(Small({{"Head", "LeftFoot"}}));

  ASSERT_THAT(clip, IsOk());
  EXPECT_EQ(clip->skeleton.joints[1].name, "LeftFoot");
  EXPECT_EQ(clip->skeleton.joints[3].name, "LeftFoot_2");
  EXPECT_THAT(clip->warnings, ElementsAre("joint names found twice got a "
                                          "number: \"LeftFoot\""));
}

// kSmall whose foot is placed by channels; its values in each frame.
std::string Placed(const std::vector<std::string>& frames) {
  std::string rows;
  for (const std::string& values : frames) {
    absl::StrAppend(&rows, "1 2 3 0 0 0 ", values, "\n");
  }
  return Small({{"CHANNELS 3 Yrotation Zrotation Xrotation",
                 "CHANNELS 4 Zrotation Xposition Yposition Zposition"},
                {"Frames: 2", absl::StrCat("Frames: ", frames.size())},
                {"1 2 3 0 0 0 0 0 0\n", rows},
                {"1 2 3 10 20 30 40 50 60\n", ""}});
}

TEST(Bvh, PutsAJointWhereItsPositionChannelsSay) {
  const auto clip = Parse(Placed({"5 0.2 -1.1 0.3", "6 0.2 -1.1 0.3"}));

  ASSERT_THAT(clip, IsOk());
  EXPECT_EQ(clip->skeleton.joints[1].offset, Vector3d(0.3, 0.2, -1.1));
  EXPECT_THAT(clip->warnings, IsEmpty());
}

TEST(Bvh, TakesTheMedianOfPositionsThatVaryAndWarns) {
  // In no coordinate is the median the first, the least or the mean.
  const auto clip = Parse(
      Placed({"5 0.27 -1.07 0.42", "6 0.21 -1.1 0.35", "7 0.2 -1.11 0.3"}));

  ASSERT_THAT(clip, IsOk());
  EXPECT_EQ(clip->skeleton.joints[1].offset, Vector3d(0.35, 0.21, -1.1));
  // By 6, 3 and 7 cm in the first frame.
  EXPECT_THAT(clip->warnings,
              ElementsAre(HasSubstr("\"LeftFoot\" by up to 9.7 cm")));
}

TEST(Bvh, KeepsTheOffsetOfARootWithoutPositionChannels) {
  const auto clip = Parse(Small(
      {{"CHANNELS 6 Xposition Yposition Zposition", "CHANNELS 4 Xposition"},
       {"1 2 3 ", "1 "}}));

  ASSERT_THAT(clip, IsOk());
  EXPECT_EQ(clip->poses[0].root_position, Vector3d(0, 1, 0.9));
}

TEST(Bvh, HoldsASingleFrame) {
  const auto clip = Parse(
      Small({{"Frames: 2", "Frames: 1"}, {"1 2 3 10 20 30 40 50 60\n", ""}}));

  ASSERT_THAT(clip, IsOk());
  ASSERT_THAT(clip->poses, SizeIs(2));
  EXPECT_DOUBLE_EQ(clip->duration(), 0.04);
  EXPECT_THAT(clip->warnings, ElementsAre(HasSubstr("single pose")));
}

TEST(Bvh, NotesHowItWasRead) {
  const auto clip = Parse(kSmall);

  ASSERT_THAT(clip, IsOk());
  EXPECT_EQ(clip->facts.format(), "bvh");
  EXPECT_EQ(clip->facts.frames_per_second(), 25);
  EXPECT_EQ(clip->facts.duration_s(), 0.04);
  EXPECT_EQ(clip->facts.metres_per_unit(), 1);
  EXPECT_EQ(clip->facts.up_axis(), "y");
  EXPECT_THAT(clip->facts.concluded(),
              ElementsAre("metres_per_unit", "up_axis"));
}

TEST(Bvh, LetsTheUserSayUnitUpAxisAndRate) {
  ReadOptions options;
  options.metres_per_unit = 0.5;
  options.up_axis = 'z';
  options.frames_per_second = 10;
  // The file's own rate makes no sense, but nobody asks for it.
  const auto clip = Parse(Small({{"0.04", "0"}}), options);

  ASSERT_THAT(clip, IsOk());
  EXPECT_EQ(clip->poses[0].root_position, Vector3d(0.5, 1, 1.5));
  EXPECT_DOUBLE_EQ(clip->duration(), 0.1);
  EXPECT_THAT(clip->facts.concluded(), IsEmpty());
}

TEST(Bvh, ReadsTheDialectOfLafan1) {
  const auto clip = Parse(testing::MadeLafanBvh(3));

  ASSERT_THAT(clip, IsOk());
  EXPECT_EQ(clip->facts.frames_per_second(), 30);
  EXPECT_EQ(clip->facts.metres_per_unit(), 0.01);
  EXPECT_EQ(clip->facts.up_axis(), "y");
  EXPECT_THAT(clip->warnings, IsEmpty());
  const std::vector<Vector3d> joints =
      WorldPositions(clip->skeleton, clip->poses[1]);
  const auto at = [&](const char* name) {
    return joints[clip->skeleton.Find(name)];
  };
  EXPECT_TRUE(at("Hips").isApprox(Vector3d(0.09, 0.1, 0.92), 1e-12));
  // 92 + 0.1 - 43.5 - 42.4 cm
  EXPECT_NEAR(at("LeftFoot").z(), 0.062, 1e-9);
  // 92 + 6.9 + 12.6 + 12.3 + 25.8 + 11.8 cm
  EXPECT_NEAR(at("Head").z(), 1.614, 1e-9);
}

class BvhError : public ::testing::TestWithParam<BadFile> {};

TEST_P(BvhError, NamesFileLineExpectedAndFound) {
  EXPECT_THAT(Parse(GetParam().text),
              testing::IsRefused("dir/clip.bvh: ", GetParam().expected));
}

std::string Nested(int depth) {
  std::string text = "HIERARCHY\nROOT a {\nOFFSET 0 0 0\n";
  for (int i = 0; i < depth; ++i) text += "JOINT a {\nOFFSET 0 0 0\n";
  return text;
}

std::string Wide(int joints) {
  std::string text = "HIERARCHY\nROOT a {\nOFFSET 0 0 0\n";
  for (int i = 0; i < joints; ++i) text += "JOINT a { OFFSET 0 0 0 }\n";
  return text;
}

INSTANTIATE_TEST_SUITE_P(
    Hierarchy, BvhError,
    ::testing::Values(
        BadFile{"", "line 0: expected HIERARCHY, found the end of the file"},
        BadFile{"walk", "line 1: expected HIERARCHY, found \"walk\""},
        BadFile{std::string("\0\xff", 2), "found \"\\x00\\xff\""},
        BadFile{"HIERARCHY\nROOT\n{", "line 2: expected a name of 1 to 128"},
        BadFile{"HIERARCHY\nROOT Hips\n}", "line 3: expected {, found \"}\""},
        BadFile{Small({{"MOTION", "ROOT b"}}),
                "line 20: expected MOTION, found \"ROOT\""},
        BadFile{Small({{"}\nMOTION", "MOTION"}}),
                "line 19: expected OFFSET, CHANNELS, JOINT, End Site or } in "
                "joint \"Hips\", found \"MOTION\""},
        BadFile{Small({{"OFFSET 0 0 0.2", "JOINT b"}}),
                "line 12: expected OFFSET or } in an End Site"},
        BadFile{Small({{"OFFSET 0.1 -1 0", ""}}),
                "expected an OFFSET in joint \"LeftFoot\", found \"}\""},
        BadFile{Small({{"OFFSET 0.1 -1 0", "OFFSET 0.1 -1 0 OFFSET"}}),
                "line 8: expected one OFFSET a joint"},
        BadFile{Small({{"OFFSET 0.1 -1 0", "OFFSET 0.1 -1"}}),
                "line 9: expected a number, found \"CHANNELS\""},
        BadFile{Small({{"OFFSET 0.1", "OFFSET 1e300"}}),
                "expected a finite number of at most 1e+09 in size, found"},
        BadFile{Nested(300), "joints, nested at most 256 deep, found more"},
        BadFile{Wide(2500), "expected at most 2000 joints"}));

INSTANTIATE_TEST_SUITE_P(
    Channels, BvhError,
    ::testing::Values(
        BadFile{Small({{"CHANNELS 3", "CHANNELS 7"}}),
                "line 9: expected a number of channels from 0 to 6, found"},
        BadFile{Small({{"CHANNELS 3", "CHANNELS 4"}}),
                "expected a channel (Xposition to Zrotation), found \"End\""},
        BadFile{Small({{"Yrotation", "Wrotation"}}), "found \"Wrotation\""},
        BadFile{Small({{"Yposition", "Xposition"}}),
                "line 5: expected each position channel once a joint"},
        BadFile{Small({{"Xposition", "Xrotation"}}),
                "line 5: expected at most 3 rotation channels, found"},
        BadFile{Small({{"OFFSET 0 0 0.2", "OFFSET 0 0 0.2 CHANNELS 1"}}),
                "line 12: expected no channels in an End Site, found"},
        BadFile{"HIERARCHY\nROOT a {\nOFFSET 0 0 0\n}\nMOTION\n",
                "expected at least one channel, found none"}));

INSTANTIATE_TEST_SUITE_P(
    Motion, BvhError,
    ::testing::Values(
        BadFile{Small({{"Frames: 2", ""}}),
                "line 22: expected \"Frames:\", found \"Frame Time: 0.04\""},
        BadFile{Small({{"Frames: 2", "Frames: two"}}),
                "\"Frames\": expected a number of at least 1, found \"two\""},
        BadFile{Small({{"Frames: 2", "Frames: 0"}}), "at least 1, found \"0\""},
        BadFile{Small({{"Frames: 2", "Frames: 3"}}),
                "expected 3 frames as \"Frames\" says, found 2"},
        BadFile{Small({{"Frames: 2", "Frames: 1"}}),
                "line 24: expected 1 frames as \"Frames\" says, found more"},
        BadFile{Small({{"0.04", "0"}}), "\"Frame Time\": expected 0.0001 to"},
        BadFile{Small({{"0.04", "-0.04"}}), "seconds, found -0.04"},
        BadFile{Small({{"0.04", "nan"}}),
                "\"Frame Time\": expected a finite number"},
        BadFile{Small({{"0.04", "1e-300"}}), "\"Frame Time\": expected 0.0001"},
        BadFile{Small({{"0.04", ""}}), "\"Frame Time\": expected a number"},
        BadFile{Small({{"40 50 60", "40 50"}}),
                "line 24: frame 1: expected 9 numbers (one per channel), found "
                "8"},
        BadFile{Small({{"40 50 60", "40 50 60 70"}}), "found 10"},
        BadFile{Small({{"40 50 60", "40 50 1,5"}}),
                "frame 1: channel 8: expected a number, found \"1,5\""},
        BadFile{Small({{"40 50 60", "40 inf 60"}}),
                "frame 1: channel 7: expected a finite number"}));

TEST(Bvh, RefusesClipsOfMoreThanFourHours) {
  std::string text = Small({{"Frames: 2", "Frames: 17"}, {"0.04", "1000"}});
  for (int i = 0; i < 15; ++i) text += "1 2 3 0 0 0 0 0 0\n";

  EXPECT_THAT(Parse(text), StatusIs(absl::StatusCode::kInvalidArgument,
                                    HasSubstr("at most 14400 s")));
}

TEST(Bvh, BoundsMemoryByTheSizeOfTheFile) {
  // Two bytes a frame would ask for 2001 rotations each.
  std::string text = absl::StrCat(Wide(1900), "JOINT b { OFFSET 0 0 0\n",
                                  "CHANNELS 1 Xrotation } }\nMOTION\n",
                                  "Frames: 100000\nFrame Time: 0.04\n");
  for (int i = 0; i < 100000; ++i) text += "0\n";

  EXPECT_THAT(Parse(text),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       HasSubstr("joints times frames in a file of its size")));
}

TEST(Bvh, RefusesOptionsThatMakeNoSense) {
  ReadOptions options;
  options.metres_per_unit = 0;

  EXPECT_THAT(Parse(kSmall, options),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("metres per unit")));
}

}  // namespace
}  // namespace sinew::import
