#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "common/testing/matchers.h"
#include "sim/character/character.h"
#include "sim/character/gains.h"
#include "sim/character/model_ptr.h"
#include "sim/character/testing/standing.h"

namespace sinew::character {
namespace {

using ::sinew::testing::IsOk;

// The published figures that humanoid.xml was made from: de Leva (1996), table
// 4, men of 1.741 m; Drillis and Contini's fractions of the stature.
constexpr double kStature = 1.70;
constexpr double kMass = 68;
constexpr double kScale = kStature / 1.741;
constexpr double kThigh = 0.245 * kStature;
constexpr double kShank = 0.246 * kStature;
constexpr double kAnkleHeight = 0.039 * kStature;
constexpr double kHipHeight = 0.530 * kStature;
constexpr double kShoulderHeight = 0.818 * kStature;

// One segment as de Leva gives it: share of the body's mass, length, distance
// of the centre from the nearer end below as a share of the length, radii of
// gyration (about x, y, z) as shares of the length.
struct Segment {
  double mass_share, length, centre;
  std::array<double, 3> radii;
};

struct Expected {
  double mass, centre_z;
  std::array<double, 3> inertia;
};

Expected FromSegment(const Segment& segment, double centre_z) {
  Expected expected = {segment.mass_share * kMass, centre_z, {}};
  for (int i = 0; i < 3; ++i) {
    const double radius = segment.radii[i] * segment.length;
    expected.inertia[i] = expected.mass * radius * radius;
  }
  return expected;
}

// Two parts of one rigid body, centres above each other.
Expected Joined(const Expected& a, const Expected& b) {
  Expected sum = {a.mass + b.mass, 0, {}};
  sum.centre_z = (a.mass * a.centre_z + b.mass * b.centre_z) / sum.mass;
  for (int i = 0; i < 3; ++i) {
    sum.inertia[i] = a.inertia[i] + b.inertia[i];
    if (i == 2) continue;
    sum.inertia[i] += a.mass * std::pow(a.centre_z - sum.centre_z, 2) +
                      b.mass * std::pow(b.centre_z - sum.centre_z, 2);
  }
  return sum;
}

// A limb that hangs from its joint.
Expected Limb(const Segment& segment) {
  return FromSegment(segment, -segment.length * segment.centre);
}

constexpr double kHeadLength = 0.2429 * kScale;
constexpr double kNeckHeight = kStature - kHeadLength - kHipHeight;
// The parts of the trunk, stretched to reach from the hips to the neck.
constexpr double kTrunkScale = kNeckHeight / (0.1457 + 0.2155 + 0.2421);
constexpr double kLower = 0.1457 * kTrunkScale;
constexpr double kMiddle = 0.2155 * kTrunkScale;
constexpr double kUpper = 0.2421 * kTrunkScale;
constexpr double kWaist = kLower + kMiddle / 2;

// One half, cut across, of the middle trunk; its own centre in its middle.
Expected HalfOfMiddleTrunk(double centre_z) {
  // The whole's radii less what the halves' distance (1/4 each) accounts for.
  const auto half = [](double radius) {
    return std::sqrt(radius * radius - 1.0 / 16);
  };
  return FromSegment(
      {0.1633 / 2, kMiddle, 0.5, {half(0.482), half(0.383), 0.468}}, centre_z);
}

std::map<std::string, Expected> Published() {
  const Segment lower = {0.1117, kLower, 0.6115, {0.615, 0.551, 0.587}};
  const Segment upper = {0.1596, kUpper, 0.5066, {0.505, 0.320, 0.465}};
  const Segment head = {0.0694, kHeadLength, 0.5002, {0.303, 0.315, 0.261}};
  return {
      {"pelvis", Joined(FromSegment(lower, kLower * (1 - lower.centre)),
                        HalfOfMiddleTrunk(kLower + kMiddle / 4))},
      {"torso",
       Joined(HalfOfMiddleTrunk(kMiddle / 4),
              FromSegment(upper, kMiddle / 2 + kUpper * (1 - upper.centre)))},
      {"head", FromSegment(head, kHeadLength * (1 - head.centre))},
      {"left_upper_arm",
       Limb({0.0271, 0.2817 * kScale, 0.5772, {0.285, 0.269, 0.158}})},
      {"left_lower_arm",
       Limb({0.0162, 0.2689 * kScale, 0.4574, {0.276, 0.265, 0.121}})},
      {"left_hand",
       Limb({0.0061, 0.0862 * kScale, 0.7900, {0.628, 0.513, 0.401}})},
      {"left_thigh", Limb({0.1416, kThigh, 0.4095, {0.329, 0.329, 0.149}})},
      {"left_shin", Limb({0.0433, kShank, 0.4459, {0.255, 0.249, 0.103}})},
  };
}

class Humanoid : public ::testing::Test {
 protected:
  void SetUp() override {
    auto loaded = Character::Load("humanoid", v1::Physics());
    ASSERT_THAT(loaded, IsOk());
    character_ = *std::move(loaded);
    data_.reset(mj_makeData(&model()));
    mj_forward(&model(), data_.get());
  }

  const mjModel& model() const { return *character_->model(); }
  int Body(const std::string& name) const {
    return mj_name2id(&model(), mjOBJ_BODY, name.c_str());
  }
  int Joint(const std::string& name) const {
    return mj_name2id(&model(), mjOBJ_JOINT, name.c_str());
  }
  double Height(const std::string& body) const {
    return data_->xpos[3 * Body(body) + 2];
  }

  std::unique_ptr<Character> character_;
  DataPtr data_;
};

TEST_F(Humanoid, HasFifteenBodiesAndTwentyEightHinges) {
  EXPECT_EQ(model().nbody, 1 + 15);
  EXPECT_EQ(character_->joints().size(), 28u);
  EXPECT_EQ(character_->tracked().size(), 15u);
  EXPECT_EQ(character_->terminating().size(), 13u);  // all but two feet
}

TEST_F(Humanoid, HasThePublishedStatureAndMass) {
  const int head = mj_name2id(&model(), mjOBJ_GEOM, "head");
  const double crown =
      data_->geom_xpos[3 * head + 2] + model().geom_size[3 * head + 2];

  EXPECT_NEAR(character_->total_mass(), kMass, 1e-3);
  EXPECT_NEAR(crown, kStature, 1e-3);
  EXPECT_NEAR(Height("left_thigh"), kHipHeight, 1e-3);
  EXPECT_NEAR(Height("left_upper_arm"), kShoulderHeight, 1e-3);
  EXPECT_NEAR(Height("left_thigh") - Height("left_shin"), kThigh, 1e-4);
  EXPECT_NEAR(Height("left_shin") - Height("left_foot"), kShank, 1e-4);
  EXPECT_NEAR(Height("left_foot"), kAnkleHeight, 1e-3);
  EXPECT_NEAR(Height("torso") - Height("pelvis"), kWaist, 1e-4);
  EXPECT_NEAR(Height("head") - Height("pelvis"), kNeckHeight, 1e-3);
}

TEST_F(Humanoid, HasLegsThatMatchTheClipsWithinACentimetre) {
  // DeepMimic's humanoid3d: thigh 0.4215 m, shank 0.4099 m.
  EXPECT_NEAR(Height("left_thigh") - Height("left_shin"), 0.4215, 0.01);
  EXPECT_NEAR(Height("left_shin") - Height("left_foot"), 0.4099, 0.01);
}

TEST_F(Humanoid, HasThePublishedMassesCentresAndInertias) {
  for (const auto& [name, expected] : Published()) {
    const int body = Body(name);
    ASSERT_GT(body, 0) << name;
    EXPECT_NEAR(model().body_mass[body], expected.mass, 1e-3) << name;
    EXPECT_NEAR(model().body_ipos[3 * body + 2], expected.centre_z, 1e-4)
        << name;
    // MuJoCo sorts principal inertias; back into the body's axes.
    mjtNum rotation[9];
    mju_quat2Mat(rotation, &model().body_iquat[4 * body]);
    for (int i = 0; i < 3; ++i) {
      double inertia = 0;
      for (int k = 0; k < 3; ++k) {
        inertia += rotation[3 * i + k] * rotation[3 * i + k] *
                   model().body_inertia[3 * body + k];
      }
      EXPECT_NEAR(inertia, expected.inertia[i], 1e-5 + 1e-3 * inertia) << name;
    }
  }
}

TEST_F(Humanoid, StandsOnItsSoles) {
  for (const std::vector<int>& geoms : character_->foot_geoms()) {
    ASSERT_EQ(geoms.size(), 1u);
    const double sole = data_->geom_xpos[3 * geoms[0] + 2] -
                        model().geom_size[3 * geoms[0] + 2];
    EXPECT_NEAR(sole, 0, 1e-3);
  }
  EXPECT_NEAR(character_->proto().standing_root_height(), Height("pelvis"),
              1e-3);
}

TEST_F(Humanoid, RestsWithAllFramesAlongTheWorlds) {
  for (int body = 1; body < model().nbody; ++body) {
    EXPECT_NEAR(data_->xquat[4 * body], 1, 1e-12);
  }
}

// A check of axes, signs and offsets at once.
TEST_F(Humanoid, MovesAlikeOnBothSides) {
  testing::ExpectMirrorImage(*character_, {.frames = 1e-9, .centres = 1e-9});
}

TEST_F(Humanoid, HasMirroredGainsMassesAndRanges) {
  for (const v1::MirrorPair& pair : character_->proto().mirror_joints()) {
    const JointInfo* sides[2] = {nullptr, nullptr};
    for (const JointInfo& joint : character_->joints()) {
      if (joint.name == pair.left()) sides[0] = &joint;
      if (joint.name == pair.right()) sides[1] = &joint;
    }
    EXPECT_EQ(sides[0]->stiffness, sides[1]->stiffness) << pair.left();
    EXPECT_EQ(sides[0]->damping, sides[1]->damping) << pair.left();
    EXPECT_EQ(sides[0]->torque_limit, sides[1]->torque_limit) << pair.left();
    if (pair.sign() < 0) continue;
    EXPECT_EQ(sides[0]->lower, sides[1]->lower) << pair.left();
    EXPECT_EQ(sides[0]->upper, sides[1]->upper) << pair.left();
  }
  for (const v1::MirrorPair& pair : character_->proto().mirror_bodies()) {
    EXPECT_EQ(model().body_mass[Body(pair.left())],
              model().body_mass[Body(pair.right())]);
  }
}

// Three hinges lose a direction where the third axis falls in line with the
// first. Within the limits they stay at least 12 degrees away from that.
TEST_F(Humanoid, HasNoSingularityWithinItsLimits) {
  constexpr double kLeast = 12 * std::numbers::pi / 180;
  for (const char* ball : {"left_hip", "right_hip", "left_shoulder",
                           "right_shoulder", "left_ankle", "chest", "neck"}) {
    const std::string name(ball);
    const mjtNum* first = &model().jnt_axis[3 * Joint(name + "_y")];
    const mjtNum* third = &model().jnt_axis[3 * Joint(name + "_z")];
    const int middle = Joint(name + "_x");
    double closest = 10;
    for (int step = 0; step <= 100; ++step) {
      const double lower = model().jnt_range[2 * middle];
      const double upper = model().jnt_range[2 * middle + 1];
      mjtNum turn[4], axis[3];
      mju_axisAngle2Quat(turn, &model().jnt_axis[3 * middle],
                         lower + (upper - lower) * step / 100);
      mju_rotVecQuat(axis, third, turn);
      const double angle = std::acos(std::abs(mju_dot3(first, axis)));
      closest = std::min(closest, angle);
    }
    EXPECT_GT(closest, kLeast) << name;
  }
}

TEST_F(Humanoid, HasTheGainsThatItsRuleGives) {
  const std::vector<Gains> gains =
      ComputeGains(model(), character_->foot_bodies(), HumanoidGainRule());

  for (const JointInfo& joint : character_->joints()) {
    const Gains& expected = gains[joint.joint_id];
    // Written with four digits.
    EXPECT_NEAR(joint.stiffness / expected.stiffness, 1, 1e-3) << joint.name;
    EXPECT_NEAR(joint.damping / expected.damping, 1, 1e-3) << joint.name;
  }
}

}  // namespace
}  // namespace sinew::character
