#include "sim/import/edit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "common/testing/matchers.h"
#include "sim/import/testing/humanoid_fixture.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;
using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

constexpr double kRate = 30;
constexpr double kPi = std::numbers::pi;

// The humanoid, and motions of it by formula.
class EditTest : public testing::HumanoidFixture {
 protected:
  EditTest() {
    auto mirror = MakeMotionMirror(*character_);
    EXPECT_THAT(mirror, IsOk());
    mirror_ = *std::move(mirror);
  }

  double& Joint(const std::string& name, VectorXd* qpos) const {
    const int id = mj_name2id(model_.model, mjOBJ_JOINT, name.c_str());
    return (*qpos)[model_.model->jnt_qposadr[id]];
  }

  VectorXd Standing() const {
    VectorXd qpos =
        Eigen::Map<const VectorXd>(model_.model->qpos0, model_.model->nq);
    qpos.head<7>() << 0, 0, character_->proto().standing_root_height(), 1, 0, 0,
        0;
    return qpos;
  }

  // Legs and arms swing with a period of 32 frames, the root goes ahead and
  // turns by `turn` per frame.
  ModelMotion Swinging(int frames, double turn = 0) const {
    ModelMotion motion;
    motion.rate = kRate;
    Vector3d place(1, 2, Standing()[2]);
    for (int t = 0; t < frames; ++t) {
      const double phase = 2 * kPi * t / 32;
      const double yaw = 0.7 + turn * t;
      VectorXd qpos = Standing();
      Joint("left_hip_y", &qpos) = 0.3 * std::sin(phase);
      Joint("right_hip_y", &qpos) = -0.3 * std::sin(phase);
      Joint("left_hip_x", &qpos) = 0.1 + 0.05 * std::cos(phase);
      Joint("right_shoulder_y", &qpos) = 0.4 * std::sin(phase + 1);
      Joint("chest_z", &qpos) = 0.2 * std::cos(phase);
      qpos.head<3>() = place;
      motion::ToWxyz(motion::YawRotation(yaw) *
                         motion::Exp({0.05 * std::sin(phase), 0.1, 0}),
                     qpos.data() + 3);
      place += motion::YawRotation(yaw) * Vector3d(0.04, 0, 0);
      motion.qpos.push_back(qpos);
    }
    return motion;
  }

  Vector3d Body(const VectorXd& qpos, const std::string& name) {
    dynamics_->SetPose(qpos);
    const int id = mj_name2id(model_.model, mjOBJ_BODY, name.c_str());
    return Eigen::Map<const Vector3d>(dynamics_->data().xpos + 3 * id);
  }

  MotionMirror mirror_;
};

Quaterniond Root(const VectorXd& qpos) {
  return motion::FromWxyz(qpos.data() + 3);
}

// Largest difference of two poses' coordinates, whatever the quaternions' sign.
double Difference(const VectorXd& a, const VectorXd& b) {
  const double rotation = motion::AngleBetween(Root(a), Root(b));
  const auto joints = a.size() - 7;
  return std::max({(a.head<3>() - b.head<3>()).cwiseAbs().maxCoeff(), rotation,
                   (a.tail(joints) - b.tail(joints)).cwiseAbs().maxCoeff()});
}

TEST_F(EditTest, VelocityOfASwingingJointHasNoLag) {
  const ModelMotion motion = Swinging(64);
  const int dof =
      model_.model
          ->jnt_dofadr[mj_name2id(model_.model, mjOBJ_JOINT, "left_hip_y")];
  const double step = 2 * kPi / 32;

  for (int t = 1; t < 63; ++t) {
    VectorXd qvel, qacc;
    Rates(*model_.model, motion, t, &qvel, &qacc);
    // The central difference of 0.3 sin(wt): its derivative at t itself, a
    // little smaller.
    EXPECT_NEAR(qvel[dof], 0.3 * std::cos(step * t) * std::sin(step) * kRate,
                1e-9);
  }
}

TEST_F(EditTest, ContactsOfAStepAreThoseOfTheFeetOnTheFloor) {
  ModelMotion motion;
  motion.rate = kRate;
  for (int t = 0; t < 60; ++t) {
    VectorXd qpos = Standing();
    // Frames 20 to 40: the left foot goes up and comes down, 4 cm in frame 23.
    const double s = std::clamp((t - 20) / 20.0, 0.0, 1.0);
    const double lift = std::sin(kPi * s);
    Joint("left_hip_y", &qpos) = -1.0 * lift * lift;
    Joint("left_knee", &qpos) = 2.0 * lift * lift;
    motion.qpos.push_back(qpos);
  }
  const int left = static_cast<int>(
      std::find(model_.feet.begin(), model_.feet.end(),
                mj_name2id(model_.model, mjOBJ_BODY, "left_foot")) -
      model_.feet.begin());

  const auto contacts = FootContacts(dynamics_.get(), motion);

  for (int t = 0; t < 60; ++t) {
    EXPECT_TRUE(contacts[t][1 - left]) << t;
    if (t < 20 || t > 40) EXPECT_TRUE(contacts[t][left]) << t;
    if (t >= 24 && t <= 36) EXPECT_FALSE(contacts[t][left]) << t;
  }
}

TEST_F(EditTest, TrimKeepsTheFramesBetweenTwoTimes) {
  const ModelMotion motion = Swinging(91);

  const auto trimmed = Trim(motion, 0.5, 1.0);

  ASSERT_THAT(trimmed, IsOk());
  ASSERT_EQ(trimmed->frames(), 16);
  EXPECT_EQ(trimmed->qpos.front(), motion.qpos[15]);
  EXPECT_EQ(trimmed->qpos.back(), motion.qpos[30]);
  EXPECT_EQ(Trim(motion, 2, INFINITY)->frames(), 31);
}

TEST_F(EditTest, TrimRefusesWhatLeavesLessThanTwoFrames) {
  const ModelMotion motion = Swinging(31);
  constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;
  EXPECT_THAT(Trim(motion, 2, 3), StatusIs(kInvalid, HasSubstr("two frames")));
  EXPECT_THAT(Trim(motion, 0.5, 0.51),
              StatusIs(kInvalid, HasSubstr("two frames, found 1")));
  EXPECT_THAT(Trim(motion, -1, 1), StatusIs(kInvalid, HasSubstr("0 <= from")));
  EXPECT_THAT(Trim(motion, 1, 1), StatusIs(kInvalid));
  EXPECT_THAT(Trim(motion, NAN, 1), StatusIs(kInvalid));
}

TEST_F(EditTest, TrimOfALoopLoopsOnlyIfItIsWhole) {
  const ModelMotion loop =
      CloseLoop(Swinging(33), {.first = 0, .last = 32, .cost = 0});
  EXPECT_TRUE(Trim(loop, 0, INFINITY)->loops);
  EXPECT_FALSE(Trim(loop, 0, 0.5)->loops);
}

TEST_F(EditTest, AlignedMotionStartsAtTheOriginAlongX) {
  const ModelMotion aligned = AlignHeading(Swinging(40, /*turn=*/0.01));

  EXPECT_NEAR(aligned.qpos[0].head<2>().norm(), 0, 1e-12);
  EXPECT_NEAR(motion::Yaw(Root(aligned.qpos[0])), 0, 1e-12);
  EXPECT_GT(aligned.qpos[5].x(), 0.15);  // it walks where it looks
}

TEST_F(EditTest, AlignedLoopGoesOnAsBefore) {
  const ModelMotion loop = CloseLoop(Swinging(33, /*turn=*/0.02),
                                     {.first = 0, .last = 32, .cost = 0});
  const ModelMotion aligned = AlignHeading(loop);
  ASSERT_GT(std::abs(aligned.cycle.yaw), 0.5);

  // Seen from the first frame, every frame is where it was.
  for (const int t : {5, 32, 70}) {
    const Vector3d before =
        motion::YawRotation(-motion::Yaw(Root(loop.qpos[0]))) *
        (FrameAt(loop, t).head<3>() - loop.qpos[0].head<3>());
    const Vector3d after =
        FrameAt(aligned, t).head<3>() - aligned.qpos[0].head<3>();
    EXPECT_NEAR((before - after).norm(), 0, 1e-9) << t;
  }
}

TEST_F(EditTest, MirrorShowsEveryBodyOnTheOtherSide) {
  const ModelMotion motion = Swinging(20, /*turn=*/0.02);
  const ModelMotion mirrored = Mirror(mirror_, motion);
  const Eigen::DiagonalMatrix<double, 3> s(1, -1, 1);

  for (const int t : {0, 7, 19}) {
    for (const v1::MirrorPair& pair : character_->proto().mirror_bodies()) {
      const Vector3d left = Body(motion.qpos[t], pair.left());
      const Vector3d right = Body(mirrored.qpos[t], pair.right());
      EXPECT_NEAR((s * left - right).norm(), 0, 1e-9) << pair.left();
      const Vector3d other = Body(motion.qpos[t], pair.right());
      EXPECT_NEAR((s * other - Body(mirrored.qpos[t], pair.left())).norm(), 0,
                  1e-9);
    }
  }
}

TEST_F(EditTest, MirroredTwiceIsTheMotionItself) {
  ModelMotion motion = CloseLoop(Swinging(33, /*turn=*/0.02),
                                 {.first = 0, .last = 32, .cost = 0});
  const ModelMotion twice = Mirror(mirror_, Mirror(mirror_, motion));
  for (int t = 0; t < motion.frames(); ++t) {
    EXPECT_EQ(twice.qpos[t], motion.qpos[t]);
  }
  EXPECT_EQ(twice.cycle.y, motion.cycle.y);
  EXPECT_EQ(twice.cycle.yaw, motion.cycle.yaw);
}

TEST_F(EditTest, LoopIsThePeriodOfAPeriodicMotion) {
  const ModelMotion motion = Swinging(100);

  const auto loop =
      FindLoop(dynamics_.get(), motion, {.least_s = 0.5, .most_s = 1.5});

  ASSERT_THAT(loop, IsOk());
  EXPECT_EQ(loop->last - loop->first, 32);
  EXPECT_LT(loop->cost, 1e-6);
  const ModelMotion closed = CloseLoop(motion, *loop);
  EXPECT_TRUE(closed.loops);
  EXPECT_NEAR(std::hypot(closed.cycle.x, closed.cycle.y), 32 * 0.04, 1e-9);
  EXPECT_EQ(closed.cycle.yaw, 0);
  for (const int t : {0, 31, 32, 50}) {
    EXPECT_NEAR(Difference(FrameAt(closed, t), motion.qpos[loop->first + t]), 0,
                1e-9);
  }
}

TEST_F(EditTest, LoopThatTurnsIsFoundToo) {
  const ModelMotion motion = Swinging(80, /*turn=*/0.02);
  const auto loop =
      FindLoop(dynamics_.get(), motion, {.least_s = 0.5, .most_s = 1.5});
  ASSERT_THAT(loop, IsOk());
  EXPECT_EQ(loop->last - loop->first, 32);
  EXPECT_NEAR(CloseLoop(motion, *loop).cycle.yaw, 32 * 0.02, 1e-9);
}

TEST_F(EditTest, ClosingALoopSpreadsTheSeamOverAllFrames) {
  ModelMotion motion = Swinging(33);
  for (int t = 0; t < motion.frames(); ++t) {
    Joint("left_knee", &motion.qpos[t]) += 0.2 * t / 32;
    motion.qpos[t][2] += 0.05 * t / 32;
    motion::ToWxyz(Root(motion.qpos[t]) * motion::Exp({0, 0.1 * t / 32, 0}),
                   motion.qpos[t].data() + 3);
  }

  const ModelMotion closed =
      CloseLoop(motion, {.first = 0, .last = 32, .cost = 0});

  // No step at the seam is larger than those within: 0.3 * 2 pi / 32 = 0.06.
  for (const int t : {30, 31, 32, 33}) {
    EXPECT_LT(Difference(FrameAt(closed, t - 1), FrameAt(closed, t)), 0.09);
  }
  VectorXd last = FrameAt(closed, 32);
  EXPECT_NEAR(Joint("left_knee", &last), 0, 0.11);
  for (int t = 0; t < 32; ++t) {
    EXPECT_LT(Difference(closed.qpos[t], motion.qpos[t]), 0.11) << t;
  }
}

TEST_F(EditTest, AMotionThatNeverRepeatsHasNoLoop) {
  ModelMotion motion = Swinging(60);
  for (int t = 0; t < 60; ++t) Joint("left_knee", &motion.qpos[t]) += 0.3 * t;
  EXPECT_THAT(
      FindLoop(dynamics_.get(), motion, {}),
      StatusIs(absl::StatusCode::kNotFound, HasSubstr("none nearer than")));
  EXPECT_THAT(
      FindLoop(dynamics_.get(), *Trim(motion, 0, 0.3), {}),
      StatusIs(absl::StatusCode::kNotFound, HasSubstr("shorter than 0.5 s")));
}

TEST_F(EditTest, BlendLeadsFromOneMotionToTheOtherWithoutAJump) {
  const ModelMotion first = Swinging(40, /*turn=*/0.01);
  const ModelMotion second = *Trim(Swinging(60), 0.3, 2);

  const auto blended = Blend(dynamics_.get(), first, second, /*gap_s=*/0.4);

  ASSERT_THAT(blended, IsOk());
  ASSERT_EQ(blended->frames(), 40 + 11 + second.frames());
  EXPECT_EQ(blended->qpos[39], first.qpos[39]);
  const auto joints = blended->qpos[0].size() - 7;
  EXPECT_EQ(blended->qpos[51].tail(joints), second.qpos[0].tail(joints));
  EXPECT_EQ(blended->qpos[51][2], second.qpos[0][2]);
  // Velocities change by less than 3 rad/s (0.1 rad per frame) per frame, in
  // the gap and where it begins and ends.
  for (int t = 36; t < 55; ++t) {
    VectorXd before(model_.model->nv), after(model_.model->nv);
    mj_differentiatePos(model_.model, before.data(), 1,
                        blended->qpos[t - 1].data(), blended->qpos[t].data());
    mj_differentiatePos(model_.model, after.data(), 1, blended->qpos[t].data(),
                        blended->qpos[t + 1].data());
    EXPECT_LT((after - before).cwiseAbs().maxCoeff(), 0.1) << t;
    EXPECT_LT(before.cwiseAbs().maxCoeff(), 0.2) << t;
  }
}

TEST_F(EditTest, BlendGoesOnInTheDirectionOfTheFirstMotion) {
  const ModelMotion first = Swinging(40);  // heading 0.7
  ModelMotion second = AlignHeading(Swinging(40));

  const auto blended = Blend(dynamics_.get(), first, second, /*gap_s=*/0.5);

  ASSERT_THAT(blended, IsOk());
  EXPECT_NEAR(motion::Yaw(Root(blended->qpos.back())), 0.7, 0.02);
  // 0.04 m per frame all the way.
  const Vector3d way =
      blended->qpos.back().head<3>() - blended->qpos.front().head<3>();
  EXPECT_NEAR(way.norm(), 0.04 * (blended->frames() - 1), 0.01);
}

TEST_F(EditTest, BlendKeepsFeetAboveTheFloor) {
  // From a crouch to a kneeling leg: straight in between would be deeper.
  ModelMotion first, second;
  first.rate = second.rate = kRate;
  VectorXd low = Standing(), high = Standing();
  Joint("left_hip_y", &low) = Joint("right_hip_y", &low) = -1.2;
  Joint("left_knee", &low) = Joint("right_knee", &low) = 2.0;
  dynamics_->SetPose(low);
  low[2] -= dynamics_->LowestHeight();
  for (int t = 0; t < 5; ++t) {
    first.qpos.push_back(low);
    second.qpos.push_back(high);
  }

  const auto blended = Blend(dynamics_.get(), first, second, /*gap_s=*/0.5);

  ASSERT_THAT(blended, IsOk());
  for (const VectorXd& qpos : blended->qpos) {
    dynamics_->SetPose(qpos);
    EXPECT_GT(dynamics_->LowestHeight(), -0.01);
  }
}

TEST_F(EditTest, BlendRefusesWhatDoesNotFit) {
  const ModelMotion motion = Swinging(10);
  ModelMotion other = motion;
  other.rate = 60;
  constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;
  EXPECT_THAT(Blend(dynamics_.get(), motion, other, 0.5),
              StatusIs(kInvalid, HasSubstr("equal rates, found 30 and 60")));
  EXPECT_THAT(Blend(dynamics_.get(), motion, motion, 0),
              StatusIs(kInvalid, HasSubstr("gap of more than 0")));
  EXPECT_THAT(Blend(dynamics_.get(), motion, motion, NAN), StatusIs(kInvalid));
}

TEST_F(EditTest, EditDoesAllInOrder) {
  const ModelMotion motion = Swinging(100);

  const auto edited = Edit(dynamics_.get(), mirror_, motion,
                           {.from_s = 0.5,
                            .to_s = 3,
                            .loop = true,
                            .loop_options = {.least_s = 0.5, .most_s = 1.5},
                            .mirror = true});

  ASSERT_THAT(edited, IsOk());
  const ModelMotion trimmed = *Trim(motion, 0.5, 3);
  const auto loop =
      FindLoop(dynamics_.get(), trimmed, {.least_s = 0.5, .most_s = 1.5});
  ASSERT_THAT(loop, IsOk());
  const ModelMotion expected = Mirror(mirror_, CloseLoop(trimmed, *loop));
  EXPECT_EQ(edited->qpos[0], expected.qpos[0]);
  EXPECT_EQ(edited->cycle.x, expected.cycle.x);
  EXPECT_EQ(edited->cycle.y, expected.cycle.y);
  EXPECT_EQ(edited->frames(), 32);
  EXPECT_TRUE(edited->loops);
  EXPECT_NEAR(std::hypot(edited->cycle.x, edited->cycle.y), 32 * 0.04, 0.01);
  EXPECT_EQ(Edit(dynamics_.get(), mirror_, motion, {})->frames(), 100);
}

}  // namespace
}  // namespace sinew::import
