#include "sim/import/retarget/retarget.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "common/testing/matchers.h"
#include "sim/character/character.h"
#include "sim/import/maps/draft_map.h"
#include "sim/import/retarget/dynamics.h"
#include "sim/import/testing/made_skeletons.h"

namespace sinew::import {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using testing::MadeClip;
using ::testing::Not;
using testing::SkeletonStyle;

// On both characters.
class RetargetTest : public ::testing::TestWithParam<const char*> {
 protected:
  RetargetTest() {
    auto loaded = character::Character::Load(GetParam(), v1::Physics());
    EXPECT_THAT(loaded, IsOk());
    character_ = *std::move(loaded);
    model_ = MakeImportModel(*character_);
    options_.refine = false;
  }

  Retargeted Play(const SkeletonStyle& style) {
    auto result = RetargetClip(model_, MadeClip(style), options_);
    EXPECT_THAT(result, IsOk());
    return *std::move(result);
  }

  // Largest distance between the bodies of two motions, m.
  double Apart(const ModelMotion& a, const ModelMotion& b) {
    EXPECT_EQ(a.frames(), b.frames());
    Dynamics dynamics(model_);
    double apart = 0;
    for (int t = 0; t < a.frames(); ++t) {
      const Eigen::Matrix3Xd first = Bodies(&dynamics, a.qpos[t]);
      const Eigen::Matrix3Xd second = Bodies(&dynamics, b.qpos[t]);
      apart = std::max(apart, (first - second).colwise().norm().maxCoeff());
    }
    return apart;
  }
  Eigen::Matrix3Xd Bodies(Dynamics* dynamics, const Eigen::VectorXd& qpos) {
    dynamics->SetPose(qpos);
    return Eigen::Map<const Eigen::Matrix3Xd>(dynamics->data().xpos, 3,
                                              model_.model->nbody);
  }

  // Crouches and rises for two seconds, `floating` metres above the floor.
  RobotClip Crouch(double floating) {
    RobotClip clip;
    clip.name = "crouch";
    for (const character::JointInfo& joint : character_->joints()) {
      clip.joints.push_back(joint.name);
    }
    const double standing = character_->proto().standing_root_height();
    for (int t = 0; t <= 120; ++t) {
      RobotPose pose;
      pose.time = t / 60.0;
      const double bend = 0.2 * (1 - std::cos(std::numbers::pi * pose.time));
      pose.root_position = {0, 0, standing * std::cos(bend) + floating};
      pose.root_rotation = Eigen::Quaterniond::Identity();
      pose.joints.resize(static_cast<int>(clip.joints.size()));
      for (size_t j = 0; j < clip.joints.size(); ++j) {
        const std::string& name = model_.semantics[j].semantic;
        double angle = 0;
        if (name.find("knee") != std::string::npos) angle = 2 * bend;
        pose.joints[static_cast<int>(j)] = angle;
      }
      clip.poses.push_back(pose);
    }
    return clip;
  }

  std::unique_ptr<const character::Character> character_;
  ImportModel model_;
  RetargetOptions options_;
};

TEST_P(RetargetTest, TheRestPoseOfTheSkeletonMakesNoDifference) {
  const Retargeted plain = Play({});
  std::vector<SkeletonStyle> styles(6);
  styles[0].arms = std::numbers::pi / 2;
  styles[1].arms = 0.8;
  styles[1].legs = 0.3;
  styles[2].heading = std::numbers::pi / 2;
  styles[3].heading = -std::numbers::pi / 2;
  styles[3].metres_per_unit = 0.01;
  styles[4].lies = true;
  styles[4].side_behind = true;
  styles[5].extra_spine = 3;
  for (size_t i = 0; i < styles.size(); ++i) {
    EXPECT_LT(Apart(Play(styles[i]).motion, plain.motion), 0.01) << i;
  }
}

TEST_P(RetargetTest, LimbsGoWhereTheSourceHasThem) {
  const Retargeted played = Play({});
  EXPECT_LT(played.quality.retarget_error_m(), 0.025);
  EXPECT_EQ(played.map, "draft");
  EXPECT_THAT(played.warnings, Contains(HasSubstr("no skeleton map fits")));
  ASSERT_EQ(played.source_joints.size(),
            static_cast<size_t>(played.motion.frames()));
  EXPECT_EQ(played.source_joints[0].size(), played.source_parents.size());
  std::vector<std::string> roles;
  for (const v1::RetargetError& error : played.quality.retarget_errors()) {
    roles.push_back(error.joint());
    EXPECT_GE(error.max_m(), error.mean_m());
  }
  EXPECT_THAT(roles, Contains("left_ankle"));
  EXPECT_THAT(roles, Contains("right_wrist"));
}

TEST_P(RetargetTest, PutsNoBodyIntoAnotherThatTheSourceHasNotThere) {
  const Retargeted played = Play({});
  EXPECT_LT(played.quality.self_penetration_added_m(), 0.005);
  EXPECT_LE(played.quality.self_penetration_added_m(),
            played.quality.self_penetration_max_m() + 1e-9);
}

TEST_P(RetargetTest, FeetThatStandStayWhereTheyAre) {
  const Retargeted played = Play({});
  EXPECT_LT(played.quality.foot_skate_m_per_s(), 0.01);
  EXPECT_LT(played.quality.foot_penetration_p99_m(), 0.005);
  EXPECT_LT(played.quality.floating_mean_m(), 0.01);
  EXPECT_EQ(played.quality.airborne_share(), 0);
  EXPECT_EQ(played.supported_share, 1);
}

TEST_P(RetargetTest, JointsKeepTheirLimits) {
  const Retargeted played = Play({});
  for (const Eigen::VectorXd& qpos : played.motion.qpos) {
    for (const character::JointInfo& joint : character_->joints()) {
      EXPECT_GE(qpos[joint.qpos_address], joint.lower - 1e-9) << joint.name;
      EXPECT_LE(qpos[joint.qpos_address], joint.upper + 1e-9) << joint.name;
    }
  }
}

TEST_P(RetargetTest, ARobotsClipIsPlayedByItsJointNames) {
  RobotClip clip = Crouch(0.1);
  clip.joints[0] = "no_such_joint";
  const auto played = FitRobotClip(model_, clip, options_);
  ASSERT_THAT(played, IsOk());
  EXPECT_THAT(played->warnings,
              Contains(AllOf(HasSubstr("no column for"),
                             HasSubstr(character_->joints()[0].name))));
  EXPECT_THAT(played->warnings, Contains(HasSubstr("no_such_joint")));
  ASSERT_EQ(played->motion.frames(), 61);
  const size_t knee = [this] {
    for (size_t j = 0; j < model_.semantics.size(); ++j) {
      if (model_.semantics[j].semantic == "left_knee") return j;
    }
    return size_t{0};
  }();
  EXPECT_NEAR(played->motion.qpos[30][model_.joints[knee].qpos_address], 0.8,
              0.01);
  // It floated.
  EXPECT_LT(played->quality.floating_mean_m(), 0.01);
  EXPECT_LT(played->quality.penetration_max_m(), 0.02);
  EXPECT_EQ(played->quality.joint_limit_violation_share(), 0);
}

TEST_P(RetargetTest, AnglesBeyondALimitAreCutAndCounted) {
  RobotClip clip = Crouch(0);
  const auto& joint = character_->joints()[3];
  for (RobotPose& pose : clip.poses) pose.joints[3] = joint.upper + 0.2;
  const auto played = FitRobotClip(model_, clip, options_);
  ASSERT_THAT(played, IsOk());
  EXPECT_NEAR(played->quality.joint_limit_violation_share(),
              1.0 / static_cast<double>(clip.joints.size()), 1e-9);
  EXPECT_EQ(played->motion.qpos[5][joint.qpos_address], joint.upper);
}

TEST_P(RetargetTest, ARobotsJumpsAndWholeTurnsAreTold) {
  const auto calm = FitRobotClip(model_, Crouch(0), options_);
  ASSERT_THAT(calm, IsOk());
  RobotClip clip = Crouch(0);
  clip.poses[40].root_position.z() += 2;
  clip.poses[70].joints[3] += 1.5;
  for (RobotPose& pose : clip.poses) pose.joints[4] += 20;

  const auto played = FitRobotClip(model_, clip, options_);

  ASSERT_THAT(played, IsOk());
  EXPECT_THAT(
      played->warnings,
      Contains(AllOf(HasSubstr("the root jumps by 2 m from frame 39 to"),
                     HasSubstr("in 0.0167 s"))));
  EXPECT_THAT(played->warnings,
              Contains(HasSubstr(clip.joints[3] + " jumps by 1.")));
  EXPECT_THAT(played->warnings,
              Contains(AllOf(HasSubstr(clip.joints[4] + " is at"),
                             HasSubstr("in frame 0, far beyond its range"))));
  // Each once, and nothing of a clip that has none.
  EXPECT_EQ(played->warnings.size(), calm->warnings.size() + 3);
}

TEST_P(RetargetTest, AJointWithoutLimitsTurnsOn) {
  RobotClip clip = Crouch(0);
  const int joint = 3;
  mjModel& m = const_cast<mjModel&>(*model_.model);
  const int id = m.dof_jntid[model_.joints[joint].dof_address];
  const mjtByte limited = m.jnt_limited[id];
  m.jnt_limited[id] = 0;
  model_.joints[joint].lower = -std::numeric_limits<double>::infinity();
  model_.joints[joint].upper = std::numeric_limits<double>::infinity();
  // Once and a half round.
  for (RobotPose& pose : clip.poses) {
    pose.joints[joint] = 1.5 * std::numbers::pi * pose.time;
  }

  const auto played = FitRobotClip(model_, clip, options_);

  m.jnt_limited[id] = limited;
  ASSERT_THAT(played, IsOk());
  const int address = model_.joints[joint].qpos_address;
  const auto& qpos = played->motion.qpos;
  for (size_t t = 1; t < qpos.size(); ++t) {
    ASSERT_NEAR(qpos[t][address] - qpos[t - 1][address],
                1.5 * std::numbers::pi / 30, 0.01)
        << t;
  }
}

TEST_P(RetargetTest, ARobotOfAnotherKindIsRefused) {
  RobotClip clip = Crouch(0);
  for (std::string& name : clip.joints) name += "_of_another";
  EXPECT_THAT(FitRobotClip(model_, clip, options_),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("crouch: expected at least half")));
}

TEST_P(RetargetTest, ACharacterWithoutFeetIsRefused) {
  model_.feet.clear();
  const auto refused = StatusIs(absl::StatusCode::kInvalidArgument,
                                HasSubstr("character: expected feet"));
  EXPECT_THAT(RetargetClip(model_, MadeClip({}), options_), refused);
  EXPECT_THAT(FitRobotClip(model_, Crouch(0), options_), refused);
}

TEST_P(RetargetTest, ACharacterWithoutKneesIsRefused) {
  for (SemanticJoint& joint : model_.semantics) {
    if (joint.semantic == "left_knee") joint.semantic = "spring";
  }
  EXPECT_THAT(RetargetClip(model_, MadeClip({}), options_),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("hinges whose semantic is left_knee")));
}

TEST_P(RetargetTest, ASkeletonWhoseAnkleIsAnEndIsRefusedAsSuch) {
  SourceClip clip = MadeClip({});
  const int ankle = clip.skeleton.Find("LeftFoot");
  ASSERT_GE(ankle, 0);
  clip.skeleton.joints[ankle].is_end = true;

  EXPECT_THAT(RetargetClip(model_, clip, options_),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("skeleton: expected a left_ankle that "
                                       "turns"),
                             Not(HasSubstr("character")))));
}

TEST_P(RetargetTest, RefusesMoreFramesThanAreBounded) {
  RobotClip crouch = Crouch(0);
  crouch.poses.back().time = 14400;  // allowed of a file
  options_.rate = 31;
  EXPECT_THAT(FitRobotClip(model_, crouch, options_),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       HasSubstr("crouch: expected at most 432000 frames, "
                                 "found 446400: 14400 s at 31 frames")));
  SourceClip made = MadeClip({});
  made.poses.back().time = 14400;
  EXPECT_THAT(RetargetClip(model_, made, options_),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       HasSubstr("made: expected at most 432000 frames")));
}

TEST_P(RetargetTest, StopsWhenItIsTold) {
  StopSource source;
  source.request_stop();
  options_.stop = source.get_token();
  EXPECT_THAT(RetargetClip(model_, MadeClip({}), options_),
              StatusIs(absl::StatusCode::kCancelled, HasSubstr("stopped")));
  EXPECT_THAT(FitRobotClip(model_, Crouch(0), options_),
              StatusIs(absl::StatusCode::kCancelled, HasSubstr("stopped")));
}

TEST_P(RetargetTest, AMapThatDoesNotFitIsRefusedByName) {
  v1::SkeletonMap map = *DraftSkeletonMap(MadeClip({}).skeleton, "mine");
  for (v1::JointRole& joint : *map.mutable_joints()) {
    if (joint.role() == "root") joint.set_source("Hipz");
  }
  options_.map = &map;
  EXPECT_THAT(RetargetClip(model_, MadeClip({}), options_),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("map mine: expected a joint \"Hipz\""),
                             HasSubstr("nearest: Hips"))));
}

INSTANTIATE_TEST_SUITE_P(Characters, RetargetTest,
                         ::testing::Values("humanoid", "g1"),
                         [](const auto& info) {
                           return std::string(info.param);
                         });

}  // namespace
}  // namespace sinew::import
