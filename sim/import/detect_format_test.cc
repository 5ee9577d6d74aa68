#include "sim/import/detect_format.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/testing/matchers.h"

namespace sinew::import {
namespace {

using ::sinew::testing::IsOkAndHolds;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

constexpr absl::StatusCode kInvalid = absl::StatusCode::kInvalidArgument;

TEST(DetectFormat, GoesByContentFirst) {
  // Whatever the file is called.
  for (const char* path : {"a.txt", "a", "b/A.BVH", "a.csv"}) {
    EXPECT_THAT(DetectFormat(path, "\xEF\xBB\xBF \nHIERARCHY\nROOT Hips"),
                IsOkAndHolds(ClipFormat::kBvh));
    EXPECT_THAT(DetectFormat(path, "# comment\n:FULLY-SPECIFIED\n1\nroot 0"),
                IsOkAndHolds(ClipFormat::kAsfAmc));
    EXPECT_THAT(DetectFormat(path, "{\"Loop\": \"wrap\", \"Frames\": [["),
                IsOkAndHolds(ClipFormat::kDeepMimic));
    EXPECT_THAT(DetectFormat(path, "Kaydara FBX Binary  \0"),
                IsOkAndHolds(ClipFormat::kFbx));
    EXPECT_THAT(DetectFormat(path, "<mujoco><keyframe><key qpos='0'/>"),
                IsOkAndHolds(ClipFormat::kKeyframes));
    EXPECT_THAT(DetectFormat(path, "PK\x03\x04....poses.npy"),
                IsOkAndHolds(ClipFormat::kSmplNpz));
    EXPECT_THAT(DetectFormat(path, "PK\x03\x04....joint_pos.npy"),
                IsOkAndHolds(ClipFormat::kRobotNpz));
  }
}

TEST(DetectFormat, GoesByTheExtensionWhereContentSaysNothing) {
  EXPECT_THAT(DetectFormat("a.csv", "0.1,0.2,0.3"),
              IsOkAndHolds(ClipFormat::kRobotCsv));
  EXPECT_THAT(DetectFormat("A.BVH", "garbage"), IsOkAndHolds(ClipFormat::kBvh));
  EXPECT_THAT(DetectFormat("a.amc", "garbage"),
              IsOkAndHolds(ClipFormat::kAsfAmc));
  EXPECT_THAT(DetectFormat("a.txt", "garbage"),
              IsOkAndHolds(ClipFormat::kDeepMimic));
}

TEST(DetectFormat, SaysWhatAFileIsThatIsNoClip) {
  EXPECT_THAT(DetectFormat("05.asf", ":version 1.10"),
              StatusIs(kInvalid, HasSubstr("05.asf: expected a motion clip, "
                                           "found a skeleton (ASF)")));
  EXPECT_THAT(DetectFormat("05_13.c3d", "\x02\x50"),
              StatusIs(kInvalid, HasSubstr("marker positions (C3D)")));
  EXPECT_THAT(DetectFormat("dog.txt", "{\"LoopMode\": \"Wrap\"}"),
              StatusIs(kInvalid, HasSubstr("robot dog")));
  EXPECT_THAT(DetectFormat("body.txt", "{\"Skeleton\": {\"Joints\": []}}"),
              StatusIs(kInvalid, HasSubstr("without motion")));
  EXPECT_THAT(DetectFormat("robot.xml", "<mujoco><worldbody/></mujoco>"),
              StatusIs(kInvalid, HasSubstr("XML without <keyframe>")));
  EXPECT_THAT(DetectFormat("weights.zip", "PK\x03\x04 data.pkl"),
              StatusIs(kInvalid, HasSubstr("without arrays of poses")));
  EXPECT_THAT(DetectFormat("empty.bvh", ""),
              StatusIs(kInvalid, HasSubstr("an empty file")));
  EXPECT_THAT(DetectFormat("film.mp4", "ftyp"),
              StatusIs(kInvalid, HasSubstr("an unknown kind of file")));
}

TEST(FormatNames, AreReadAsTheyArePrinted) {
  for (const ClipFormat format :
       {ClipFormat::kBvh, ClipFormat::kAsfAmc, ClipFormat::kSmplNpz,
        ClipFormat::kRobotNpz, ClipFormat::kDeepMimic, ClipFormat::kRobotCsv,
        ClipFormat::kKeyframes, ClipFormat::kFbx}) {
    EXPECT_THAT(FormatOfName(FormatName(format)), IsOkAndHolds(format));
  }
  EXPECT_THAT(FormatOfName("bvx"),
              StatusIs(kInvalid, HasSubstr("expected one of bvh, asf_amc")));
}

}  // namespace
}  // namespace sinew::import
