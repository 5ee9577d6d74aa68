#include "sim/import/clip_name.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/testing/matchers.h"

namespace sinew::import {
namespace {

using ::sinew::testing::IsOkAndHolds;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(ClipName, IsTheFileNameWithoutFolderAndExtension) {
  EXPECT_EQ(ClipName("a/b c/walk 01.final.bvh"), "walk 01.final");
  EXPECT_EQ(ClipName("walk"), "walk");
  EXPECT_EQ(ClipName("a/.hidden"), ".hidden");
}

TEST(ClipName, IsValidUtf8WhateverThePathHolds) {
  EXPECT_EQ(ClipName("m\u00E4rz/l\u00E4uft \u6B69.bvh"), "l\u00E4uft \u6B69");
  EXPECT_EQ(ClipName("caf\xE9.bvh"), "caf%E9");          // Latin-1
  EXPECT_EQ(ClipName("\xC0\xAF.bvh"), "%C0%AF");         // overlong
  EXPECT_EQ(ClipName("a\nb.bvh"), "a%0Ab");              // breaks tables
  EXPECT_EQ(ClipName("\xED\xA0\x80.bvh"), "%ED%A0%80");  // a surrogate
}

TEST(TrialName, OfCmuIsSubjectAndTrialInEveryFormat) {
  for (const char* path :
       {"cmu_amc/02/02_04.amc", "cmu_bvh/02/02_04.bvh", "02_04.amc",
        "mocap/CMU/02_04_scaled.bvh", "x/CMU-CMU-02-02_04_poses.xml",
        "archive/02/02_04_poses.npz", "cmu/2_04.bvh"}) {
    EXPECT_EQ(TrialName(path), "cmu/02_04") << path;
  }
  EXPECT_EQ(TrialName("cmu_bvh/max_friendly/scaled_131_01.bvh"), "cmu/131_01");
  EXPECT_EQ(TrialName("cmu_bvh/other/01_01_fairmotion.bvh"), "cmu/01_01");
}

TEST(TrialName, DoesNotSeeCmuInEveryNumber) {
  EXPECT_EQ(TrialName("mine/take_03_12_run.bvh"), "take_03_12_run");
  EXPECT_EQ(TrialName("react_idle/000_genuine.bvh"), "000_genuine");
}

TEST(TrialName, OfAClipInTwoFormatsAndItsMirrorImageIsOne) {
  EXPECT_EQ(TrialName("smpl_npz/video_walk_level1_filter_amass.npz"),
            TrialName("g1_csv/video_walk_level1_filter_amass.csv"));
  EXPECT_EQ(TrialName("a/humanoid3d_walk_mirror.txt"), "humanoid3d_walk");
  EXPECT_EQ(TrialName("a/Walk_poses_mirrored.npz"), "walk");
}

TEST(TrialName, OfAVideoIsTheSameOnATestbed) {
  const char* video = "smpl_npz/video_CR7_level1_filter_amass.npz";
  const char* on_testbed =
      "g1_csv_converted/TairanTestbed_TairanTestbed_CR7_video_CR7_level1_"
      "filter_amass.csv";

  EXPECT_EQ(TrialName(video), "video_cr7_level1_filter_amass");
  EXPECT_EQ(TrialName(on_testbed), TrialName(video));
}

TEST(TrialName, KeepsWhatStandsBeforeAVideoAndIsNoTestbed) {
  EXPECT_EQ(TrialName("a/hall_video_walk.bvh"), "hall_video_walk");
  EXPECT_EQ(TrialName("a/video_testbed.bvh"), "video_testbed");
  EXPECT_EQ(TrialName("a/testbed_walk.bvh"), "testbed_walk");
}

TEST(UniqueNames, TakesTheFolderInForAnotherFileOfTheSameName) {
  const auto names = UniqueNames({{"bvh/02/02_01.bvh", "a"},
                                  {"amc/02/02_01.amc", "b"},
                                  {"walk/02_01.bvh", "c"},
                                  {"02_01.txt", "d"}});

  EXPECT_THAT(names[0], IsOkAndHolds("02_01"));
  EXPECT_THAT(names[1], IsOkAndHolds("02_02_01"));
  EXPECT_THAT(names[2], IsOkAndHolds("walk_02_01"));
  EXPECT_THAT(names[3], IsOkAndHolds("02_01_txt"));  // no folder
}

TEST(UniqueNames, RefusesTheSameFileAndTheSameContentTwice) {
  const auto names = UniqueNames({{"a/walk.bvh", "a"},
                                  {"a/walk.bvh", "a"},
                                  {"b/walk.bvh", "a"},
                                  {"b/stroll.bvh", "a"}});

  EXPECT_THAT(names[0], IsOkAndHolds("walk"));
  for (int i = 1; i <= 2; ++i) {
    EXPECT_THAT(names[i],
                StatusIs(absl::StatusCode::kAlreadyExists,
                         AllOf(HasSubstr("expected a unique name, found "
                                         "\"walk\" twice"),
                               HasSubstr("also a/walk.bvh"))));
  }
  EXPECT_THAT(names[3], IsOkAndHolds("stroll"));  // a name of its own
}

TEST(UniqueNames, TakesANameThatIsGivenInsteadOfTheFiles) {
  const auto names = UniqueNames({{"a/walk.bvh", "1"},
                                  {"a/walk.bvh", "2", "walk_to_run"},
                                  {"a/walk.bvh", "3", "walk_to_run"},
                                  {"b/walk.bvh", "2", "walk_to_run"}});

  EXPECT_THAT(names[1], IsOkAndHolds("walk_to_run"));
  EXPECT_THAT(names[2], IsOkAndHolds("a_walk_to_run"));  // to another run
  EXPECT_THAT(names[3], StatusIs(absl::StatusCode::kAlreadyExists));
}

TEST(UniqueNames, RefusesWhatNoFolderTellsApart) {
  const auto names = UniqueNames({{"x/a/walk.bvh", "1"},
                                  {"y/a/walk.bvh", "2"},
                                  {"z/a/walk.bvh", "3"},
                                  {"w/a/walk.bvh", "4"},
                                  {"v/a/walk.bvh", "5"}});

  EXPECT_THAT(names[1], IsOkAndHolds("a_walk"));
  EXPECT_THAT(names[3], IsOkAndHolds("a_walk_bvh"));
  EXPECT_THAT(names[4], StatusIs(absl::StatusCode::kAlreadyExists));
}

}  // namespace
}  // namespace sinew::import
