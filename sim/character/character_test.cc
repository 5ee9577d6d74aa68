#include "sim/character/character.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "common/config/recipe.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "sim/character/gains.h"

namespace sinew::character {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

v1::Physics MakePhysics() { return WithDefaults(v1::Recipe()).physics(); }

std::unique_ptr<Character> LoadHumanoid(
    const v1::Physics& physics = MakePhysics()) {
  auto character = Character::Load("humanoid", physics);
  EXPECT_THAT(character, IsOk());
  return *std::move(character);
}

// A folder with a character of one leg whose parts a test may replace.
constexpr char kModel[] = R"(<mujoco><worldbody><body name="root">
  <freejoint/><geom size="0.1"/>
  <body name="leg" pos="0 0 -0.3"><joint name="knee" axis="0 1 0"/>
    <geom name="sole" size="0.05"/></body></body></worldbody></mujoco>)";
constexpr char kText[] = R"(format_version: 1 name: "hopper"
  model_file: "m.xml" head_body: "root" standing_root_height: 0.4
  actuator_law { derivation: "test" } feet { body: "leg" }
  joints { name: "knee" stiffness: 10 damping: 1 torque_limit: 5 })";

absl::StatusOr<std::unique_ptr<Character>> LoadFrom(const std::string& text,
                                                    const std::string& model) {
  const std::string folder = JoinPath(
      ::testing::TempDir(),
      ::testing::UnitTest::GetInstance()->current_test_info()->name());
  EXPECT_THAT(MakeDirectories(folder), IsOk());
  EXPECT_THAT(WriteFileAtomically(JoinPath(folder, "m.xml"), model), IsOk());
  const std::string path = JoinPath(folder, "character.textproto");
  EXPECT_THAT(WriteFileAtomically(path, text), IsOk());
  return Character::Load(path, MakePhysics());
}

std::string Replaced(std::string text, const std::string& from,
                     const std::string& to) {
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos);
  return text.replace(at, from.size(), to);
}

TEST(Humanoid, HasFifteenBodiesAndTwentyEightHinges) {
  const auto humanoid = LoadHumanoid();

  EXPECT_EQ(humanoid->model()->nbody, 1 + 15);
  EXPECT_EQ(humanoid->joints().size(), 28u);
  EXPECT_EQ(humanoid->tracked().size(), 15u);
  EXPECT_EQ(humanoid->terminating().size(), 13u);  // all but two feet
}

TEST(Humanoid, WeighsSixtyEightKilogramsAndStandsOnItsSoles) {
  const auto humanoid = LoadHumanoid();
  const mjModel& model = *humanoid->model();
  const DataPtr data(mj_makeData(&model));
  mj_forward(&model, data.get());

  EXPECT_NEAR(humanoid->total_mass(), 68, 0.01);
  for (const std::vector<int>& geoms : humanoid->foot_geoms()) {
    ASSERT_EQ(geoms.size(), 1u);
    const double sole = data->geom_xpos[3 * geoms[0] + 2] -
                        model.geom_size[3 * geoms[0] + 2];
    EXPECT_NEAR(sole, 0, 1e-3);
  }
  const int head = humanoid->head_body();
  const double crown = data->xpos[3 * head + 2] + 0.1272 + 0.11;
  EXPECT_NEAR(crown, 1.70, 0.01);
}

TEST(Humanoid, IsSymmetric) {
  const auto humanoid = LoadHumanoid();
  const mjModel& model = *humanoid->model();

  for (const v1::MirrorPair& pair : humanoid->proto().mirror_bodies()) {
    const int left = mj_name2id(&model, mjOBJ_BODY, pair.left().c_str());
    const int right = mj_name2id(&model, mjOBJ_BODY, pair.right().c_str());
    EXPECT_EQ(model.body_mass[left], model.body_mass[right]) << pair.left();
    for (int i = 0; i < 3; ++i) {
      const double sign = i == 1 ? -1 : 1;
      EXPECT_EQ(model.body_pos[3 * left + i],
                sign * model.body_pos[3 * right + i])
          << pair.left();
    }
  }
}

TEST(Humanoid, HasTheGainsThatTheRuleGives) {
  const auto humanoid = LoadHumanoid();
  const std::vector<Gains> gains =
      ComputeGains(*humanoid->model(), humanoid->foot_bodies());

  for (const JointInfo& joint : humanoid->joints()) {
    const Gains& expected = gains[joint.joint_id];
    EXPECT_NEAR(joint.stiffness, expected.stiffness, 0.06) << joint.name;
    EXPECT_NEAR(joint.damping, expected.damping, 0.006) << joint.name;
  }
}

TEST(Character, PutsGainDampingIntoTheModel) {
  const auto humanoid = LoadHumanoid();

  for (const JointInfo& joint : humanoid->joints()) {
    EXPECT_EQ(humanoid->model()->dof_damping[joint.dof_address], joint.damping);
  }
}

TEST(Character, TouchesTheFloorOnlyUnlessAsked) {
  v1::Physics physics = MakePhysics();
  const auto plain = LoadHumanoid(physics);
  physics.set_self_collision(true);
  const auto colliding = LoadHumanoid(physics);

  // Arms crossed through the trunk.
  for (const auto* humanoid : {plain.get(), colliding.get()}) {
    const mjModel& model = *humanoid->model();
    const DataPtr data(mj_makeData(&model));
    data->qpos[2] = 3;
    for (const JointInfo& joint : humanoid->joints()) {
      if (joint.name == "left_shoulder_x" || joint.name == "right_shoulder_x") {
        data->qpos[joint.qpos_address] = -0.8;
      }
    }
    mj_forward(&model, data.get());
    EXPECT_EQ(data->ncon > 0, humanoid == colliding.get());
  }
  // At rest nothing touches but the soles.
  const DataPtr data(mj_makeData(colliding->model()));
  mj_forward(colliding->model(), data.get());
  for (int i = 0; i < data->ncon; ++i) {
    EXPECT_EQ(data->contact[i].geom[0], colliding->floor_geom());
  }
}

TEST(Character, ComesBackFromItsAssetsWithTheSameDigest) {
  const auto humanoid = LoadHumanoid();

  auto copy = Character::FromAssets(humanoid->character_text(),
                                    humanoid->model_binary(), "asset");

  ASSERT_THAT(copy, IsOk());
  EXPECT_EQ((*copy)->digest(), humanoid->digest());
  EXPECT_EQ((*copy)->model_binary(), humanoid->model_binary());
}

TEST(Character, HasADigestThatDoesNotDependOnPhysicsSettings) {
  v1::Physics fast = MakePhysics();
  fast.set_physics_hz(480);
  fast.set_self_collision(true);

  EXPECT_EQ(LoadHumanoid(fast)->digest(), LoadHumanoid()->digest());
}

TEST(Character, RefusesBytesThatAreNoModel) {
  const auto humanoid = LoadHumanoid();

  EXPECT_THAT(
      Character::FromAssets(humanoid->character_text(), "not a model", "asset"),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("expected a binary model of MuJoCo")));
}

TEST(Character, NamesWhereItLookedForAnUnknownOne) {
  EXPECT_THAT(Character::Load("nobody", MakePhysics()),
              StatusIs(absl::StatusCode::kNotFound,
                       HasSubstr("nobody/character.textproto in ")));
}

TEST(Character, LoadsAModelWithoutFloorAndAddsOne) {
  auto hopper = LoadFrom(kText, kModel);

  ASSERT_THAT(hopper, IsOk());
  EXPECT_GE((*hopper)->floor_geom(), 0);
}

struct BadCharacter {
  std::string from, to;
  bool in_model;
  std::string expected;
};

class CharacterError : public ::testing::TestWithParam<BadCharacter> {};

TEST_P(CharacterError, NamesFieldExpectedAndFound) {
  const BadCharacter& bad = GetParam();
  const std::string text =
      bad.in_model ? kText : Replaced(kText, bad.from, bad.to);
  const std::string model =
      bad.in_model ? Replaced(kModel, bad.from, bad.to) : kModel;

  EXPECT_THAT(LoadFrom(text, model),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr(bad.expected)));
}

INSTANTIATE_TEST_SUITE_P(
    All, CharacterError,
    ::testing::Values(
        BadCharacter{"<geom size=\"0.1\"/>", "<geom size=\"-1\"/>", true,
                     "m.xml: "},
        BadCharacter{"<freejoint/>", "", true, "expected one free joint"},
        BadCharacter{"format_version: 1", "format_version: 2", false,
                     "format_version: expected 1, found 2"},
        BadCharacter{"name: \"knee\"", "name: \"hip\"", false,
                     "no joint \"hip\" in the model"},
        BadCharacter{"name=\"knee\"", "name=\"knee\" type=\"slide\"", true,
                     "expected a hinge"},
        BadCharacter{"stiffness: 10", "stiffness: -10", false,
                     "joint knee stiffness: expected > 0, found -10"},
        BadCharacter{"torque_limit: 5", "torque_limit: nan", false,
                     "joint knee torque_limit: expected > 0"},
        BadCharacter{"body: \"leg\"", "body: \"toe\"", false,
                     "feet: no body \"toe\""},
        BadCharacter{"head_body: \"root\"", "head_body: \"hat\"", false,
                     "head_body: no body \"hat\""},
        BadCharacter{"name: \"hopper\"", "name: \"Hop per\"", false,
                     "expected [a-z0-9_]+"},
        BadCharacter{"derivation: \"test\"", "", false,
                     "actuator_law.derivation"}));

}  // namespace
}  // namespace sinew::character
