#include "sim/import/formats/first_frame.h"

#include <gtest/gtest.h>

#include <numbers>

namespace sinew::import {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

// Two joints at rest, then a swing of 1 degree a frame from `start` degrees.
SourceClip Swing(double start, int frames = 12) {
  SourceClip clip;
  clip.skeleton.joints = {{"Hips", -1, Vector3d::Zero()},
                          {"LeftLeg", 0, -Vector3d::UnitZ()},
                          {"RightLeg", 0, -Vector3d::UnitZ()}};
  for (int i = 0; i < frames; ++i) {
    SourcePose pose;
    pose.time = 0.1 * i;
    pose.root_position = Vector3d(i, 0, 1);
    pose.rotation.assign(3, Quaterniond::Identity());
    const double degrees = i == 0 ? 0 : start + i;
    pose.rotation[1] = pose.rotation[2] =
        AngleAxisd(degrees * std::numbers::pi / 180, Vector3d::UnitY());
    clip.poses.push_back(pose);
  }
  return clip;
}

TEST(FirstFrame, IsRestIfTheMotionJumpsAwayFromIt) {
  EXPECT_TRUE(FirstFrameIsRest(Swing(/*start=*/20)));
}

TEST(FirstFrame, IsRestThoughTheMotionJumpsElsewhereToo) {
  SourceClip clip = Swing(/*start=*/20);
  clip.poses[3].rotation[1] = Quaterniond::Identity();

  EXPECT_TRUE(FirstFrameIsRest(clip));
}

TEST(FirstFrame, IsPartOfAMotionThatGoesOnSmoothly) {
  EXPECT_FALSE(FirstFrameIsRest(Swing(/*start=*/0)));
  EXPECT_FALSE(FirstFrameIsRest(Swing(/*start=*/3)));
}

TEST(FirstFrame, IsPartOfAMotionThatStartsWithTurnedJoints) {
  SourceClip clip = Swing(/*start=*/20);
  for (Quaterniond& rotation : clip.poses[0].rotation) {
    rotation = AngleAxisd(0.1, Vector3d::UnitX());
  }

  EXPECT_FALSE(FirstFrameIsRest(clip));
}

TEST(FirstFrame, OfAVeryShortClipIsKept) {
  EXPECT_FALSE(FirstFrameIsRest(Swing(/*start=*/20, /*frames=*/3)));
}

TEST(DropFirstPose, LetsTheSecondPoseStartTheClip) {
  SourceClip clip = Swing(/*start=*/20);

  DropFirstPose(clip);

  ASSERT_EQ(clip.poses.size(), 11u);
  EXPECT_EQ(clip.poses[0].time, 0);
  EXPECT_EQ(clip.poses[0].root_position, Vector3d(1, 0, 1));
  EXPECT_DOUBLE_EQ(clip.duration(), 1.0);
  EXPECT_DOUBLE_EQ(clip.facts.duration_s(), 1.0);
}

}  // namespace
}  // namespace sinew::import
