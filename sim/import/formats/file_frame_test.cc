#include "sim/import/formats/file_frame.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "common/testing/matchers.h"

namespace sinew::import {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

using Eigen::Quaterniond;
using Eigen::Vector3d;

// Hips, a foot below and a head above, in two poses; `up` is the file's, and
// the leg, 1 m long, has `units` units.
SourceClip Standing(double units, const Vector3d& up) {
  SourceClip clip;
  clip.skeleton.joints = {{"Hips", -1, Vector3d::Zero()},
                          {"LeftLeg", 0, -0.5 * units * up},
                          {"LeftFoot", 1, -0.5 * units * up},
                          {"Head", 0, 0.6 * units * up}};
  SourcePose pose;
  pose.root_position = units * up;
  pose.rotation.assign(4, Quaterniond::Identity());
  clip.poses = {pose, pose};
  return clip;
}

SourceClip Moved(SourceClip clip, const ReadOptions& options = {},
                 const FileFrame& file = {}) {
  MoveToWorld(file, options, clip);
  return clip;
}

TEST(MoveToWorld, ConcludesEachUsualUnitFromTheLegs) {
  for (const double unit : {1.0, 0.1, 0.01, 0.001, 0.0254, 0.0254 / 0.45}) {
    const SourceClip clip = Moved(Standing(1 / unit, Vector3d::UnitY()));

    EXPECT_DOUBLE_EQ(clip.facts.metres_per_unit(), unit);
    EXPECT_THAT(clip.facts.concluded(),
                ElementsAre("metres_per_unit", "up_axis"));
    EXPECT_THAT(clip.warnings, IsEmpty());
    EXPECT_NEAR(clip.poses[0].root_position.z(), 1, 1e-12);
  }
}

TEST(MoveToWorld, TakesASkeletonThatNoUnitFitsForAGrownPerson) {
  // At 25 units for a leg of 1.1 m neither 0.0254 nor 0.0564 m fits.
  const SourceClip clip = Moved(Standing(28.5, Vector3d::UnitY()));

  EXPECT_NEAR(clip.facts.metres_per_unit(), 1.1 / 28.5, 1e-12);
  EXPECT_THAT(clip.warnings, ElementsAre(HasSubstr("no usual unit")));
}

TEST(MoveToWorld, LeavesASkeletonWithoutSizeInMetresWithAWarning) {
  const SourceClip clip = Moved(Standing(0, Vector3d::UnitY()));

  EXPECT_EQ(clip.facts.metres_per_unit(), 1);
  EXPECT_THAT(clip.warnings, SizeIs(1));
}

TEST(MoveToWorld, BelievesTheFileAndTheUserMoreThanTheFile) {
  FileFrame file;
  file.metres_per_unit = 0.5;
  file.up_axis = 'x';
  const SourceClip by_file = Moved(Standing(1, Vector3d::UnitY()), {}, file);
  ReadOptions options;
  options.metres_per_unit = 2;
  options.up_axis = 'z';
  const SourceClip by_user =
      Moved(Standing(1, Vector3d::UnitY()), options, file);

  EXPECT_EQ(by_file.facts.metres_per_unit(), 0.5);
  EXPECT_EQ(by_file.facts.up_axis(), "x");
  EXPECT_THAT(by_file.facts.concluded(), IsEmpty());
  EXPECT_EQ(by_user.facts.metres_per_unit(), 2);
  EXPECT_EQ(by_user.poses[0].root_position, Vector3d(0, 2, 0));
  EXPECT_THAT(by_user.facts.concluded(), IsEmpty());
}

TEST(MoveToWorld, KeepsAUsualUnitOnlyIfAPersonComesOut) {
  FileFrame file;
  file.usual_metres_per_unit = 0.9;
  const SourceClip fits = Moved(Standing(1, Vector3d::UnitY()), {}, file);
  const SourceClip does_not = Moved(Standing(100, Vector3d::UnitY()), {}, file);

  EXPECT_EQ(fits.facts.metres_per_unit(), 0.9);
  EXPECT_EQ(does_not.facts.metres_per_unit(), 0.01);
}

TEST(MoveToWorld, TurnsAxesCyclicallySoThatRotationsStayRotations) {
  struct Case {
    char up;
    Vector3d world_of_123;  // of (1, 2, 3) in the file
  };
  const Case cases[] = {{'x', {2, 3, 1}}, {'y', {3, 1, 2}}, {'z', {1, 2, 3}}};
  for (const Case& c : cases) {
    SourceClip clip = Standing(1, Vector3d::UnitY());
    clip.poses[0].root_position = Vector3d(1, 2, 3);
    clip.poses[0].rotation[0] =
        Eigen::AngleAxisd(0.5, Vector3d(1, 2, 3).normalized());
    ReadOptions options;
    options.up_axis = c.up;
    options.metres_per_unit = 1;

    MoveToWorld({}, options, clip);

    EXPECT_EQ(clip.poses[0].root_position, c.world_of_123) << c.up;
    const Quaterniond expected(
        Eigen::AngleAxisd(0.5, c.world_of_123.normalized()));
    EXPECT_TRUE(clip.poses[0].rotation[0].isApprox(expected, 1e-12)) << c.up;
  }
}

TEST(MoveToWorld, FindsUpInARestPoseThatStands) {
  EXPECT_EQ(Moved(Standing(1, Vector3d::UnitY())).facts.up_axis(), "y");
  EXPECT_EQ(Moved(Standing(1, Vector3d::UnitZ())).facts.up_axis(), "z");
}

TEST(MoveToWorld, FindsUpInThePosesIfTheRestPoseLies) {
  // The rest pose lies along x; the root of the poses sets it upright.
  for (const auto& [axis, up] : {std::pair(Vector3d::UnitZ().eval(), "y"),
                                 std::pair((-Vector3d::UnitY()).eval(), "z")}) {
    SourceClip clip = Standing(1, Vector3d::UnitX());
    for (SourcePose& pose : clip.poses) {
      pose.rotation[0] = Eigen::AngleAxisd(M_PI / 2, axis);
    }
    EXPECT_EQ(Moved(clip).facts.up_axis(), up);
  }
}

TEST(MoveToWorld, FindsUpInTheRootIfNothingIsCalledAFoot) {
  SourceClip clip = Standing(1, Vector3d::UnitZ());
  clip.skeleton.joints[2].name = "Box";
  clip.poses[1].root_position += Vector3d(1, 1, 0.1);
  EXPECT_EQ(Moved(clip).facts.up_axis(), "z");

  clip.poses[0].root_position = clip.poses[1].root_position = Vector3d::Zero();
  EXPECT_EQ(Moved(clip).facts.up_axis(), "y");
}

TEST(SetTimes, SpacesPosesEvenlyAndNotesRateAndDuration) {
  SourceClip clip = Standing(1, Vector3d::UnitY());

  ASSERT_THAT(SetTimes(30, "a.bvh", clip), IsOk());

  EXPECT_DOUBLE_EQ(clip.poses[1].time, 1.0 / 30);
  EXPECT_DOUBLE_EQ(clip.facts.frames_per_second(), 30);
  EXPECT_DOUBLE_EQ(clip.facts.duration_s(), 1.0 / 30);
  EXPECT_THAT(clip.warnings, IsEmpty());
}

TEST(SetTimes, HoldsASinglePoseForOneFrame) {
  SourceClip clip = Standing(1, Vector3d::UnitY());
  clip.poses.pop_back();

  ASSERT_THAT(SetTimes(24, "a.bvh", clip), IsOk());

  ASSERT_THAT(clip.poses, SizeIs(2));
  EXPECT_DOUBLE_EQ(clip.duration(), 1.0 / 24);
  EXPECT_THAT(clip.warnings, ElementsAre(HasSubstr("held for one frame")));
}

TEST(SetTimes, RefusesClipsOfMoreThanFourHours) {
  SourceClip clip = Standing(1, Vector3d::UnitY());
  clip.poses.assign(16, clip.poses[0]);  // 15 s / 0.001 = 15 000 s

  EXPECT_THAT(SetTimes(1e-3, "a.bvh", clip),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("a.bvh: expected a clip of at most 14400 s, "
                                 "found 16 frames at 0.001 a second")));
}

TEST(RateOfFrameTime, UndoesTheRoundingOfFrameTimes) {
  EXPECT_EQ(RateOfFrameTime(0.0083333), 120);
  EXPECT_EQ(RateOfFrameTime(0.03333), 30);
  EXPECT_EQ(RateOfFrameTime(0.041667), 24);
  EXPECT_NEAR(RateOfFrameTime(0.008342), 119.875, 1e-3);
  EXPECT_NEAR(RateOfFrameTime(1.001 / 30), 29.97, 1e-3);
}

TEST(CheckFixedFrame, RefusesWhatTheFormatCannotBe) {
  const auto check = [](const ReadOptions& options) {
    return CheckFixedFrame(options, 1, 'z', "MuJoCo", "a.xml");
  };
  EXPECT_THAT(check({}), IsOk());
  EXPECT_THAT(check({.metres_per_unit = 1, .up_axis = 'z'}), IsOk());
  EXPECT_THAT(check({.metres_per_unit = 0.5}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("a.xml: metres_per_unit: expected 1, as "
                                 "MuJoCo always has it, found 0.5")));
  EXPECT_THAT(check({.up_axis = 'y'}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("a.xml: up_axis: expected z, as MuJoCo always "
                                 "has it, found y")));
}

TEST(CheckReadOptions, NamesWhatMakesNoSense) {
  const auto check = [](auto change) {
    ReadOptions options;
    change(options);
    return CheckReadOptions(options);
  };
  EXPECT_THAT(CheckReadOptions({}), IsOk());
  EXPECT_THAT(check([](ReadOptions& o) { o.metres_per_unit = -1; }),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("metres per unit: expected")));
  EXPECT_THAT(check([](ReadOptions& o) { o.frames_per_second = NAN; }),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("frames per second: expected")));
  EXPECT_THAT(check([](ReadOptions& o) { o.up_axis = 'w'; }),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("up axis: expected x, y or z, found \"w\"")));
  EXPECT_THAT(check([](ReadOptions& o) { o.quaternion_order = "wzyx"; }),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("quaternion order: expected wxyz or xyzw")));
}

}  // namespace
}  // namespace sinew::import
