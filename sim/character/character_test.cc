#include "sim/character/character.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/config/recipe.h"
#include "common/files.h"
#include "common/testing/matchers.h"

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
constexpr char kModel[] =
    R"(<mujoco><compiler angle="radian"/><worldbody><body name="root">
  <freejoint/><geom size="0.1"/>
  <body name="leg" pos="0 0 -0.3">
    <joint name="knee" type="hinge" axis="0 1 0" range="-1 1"/>
    <geom name="sole" size="0.05" mass="1"/>
    </body></body></worldbody></mujoco>)";
constexpr char kText[] = R"(format_version: 1 name: "hopper"
  model_file: "m.xml" head_body: "root" standing_root_height: 0.4
  actuator_law { derivation: "test" } feet { body: "leg" }
  joints { name: "knee" stiffness: 10 damping: 1 torque_limit: 5 })";

absl::StatusOr<std::unique_ptr<Character>> LoadFrom(const std::string& text,
                                                    const std::string& model) {
  const std::string folder =
      JoinPath(::testing::TempDir(),
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
               HasSubstr("asset: expected a compiled model of MuJoCo ")));
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

  EXPECT_THAT(
      LoadFrom(text, model),
      StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr(bad.expected)));
}

constexpr bool kInText = false;
constexpr bool kInModel = true;

INSTANTIATE_TEST_SUITE_P(
    Text, CharacterError,
    ::testing::Values(
        BadCharacter{"format_version: 1", "format_version: 2", kInText,
                     "format_version: expected 1, found 2"},
        BadCharacter{"name: \"hopper\"", "name: \"Hop per\"", kInText,
                     "name: expected lower-case letters, digits and _"},
        BadCharacter{"model_file: \"m.xml\"", "", kInText,
                     "model_file: expected a file"},
        BadCharacter{"feet {", "feat {", kInText, "line 3, column"},
        BadCharacter{"name: \"knee\"", "", kInText,
                     "joints.name: expected a name"},
        BadCharacter{"stiffness: 10", "stiffness: -10", kInText,
                     "joint \"knee\": stiffness: expected a number > 0, found "
                     "-10"},
        BadCharacter{"damping: 1", "damping: -1", kInText,
                     "joint \"knee\": damping: expected a number >= 0"},
        BadCharacter{"torque_limit: 5", "torque_limit: nan", kInText,
                     "joint \"knee\": torque_limit: expected a number > 0, "
                     "found nan"},
        BadCharacter{"torque_limit: 5", "torque_limit: 5 armature: -1", kInText,
                     "joint \"knee\": armature: expected a number >= 0"},
        BadCharacter{"standing_root_height: 0.4", "", kInText,
                     "standing_root_height: expected a number > 0, found 0"},
        BadCharacter{"derivation: \"test\"", "", kInText,
                     "actuator_law.derivation: expected"},
        BadCharacter{"feet { body: \"leg\" }", "", kInText,
                     "feet: expected at least one, found 0"}));

INSTANTIATE_TEST_SUITE_P(
    Names, CharacterError,
    ::testing::Values(
        BadCharacter{"name: \"knee\"", "name: \"hip\"", kInText,
                     "found \"hip\", which it does not have"},
        BadCharacter{"torque_limit: 5", "torque_limit: 5 default_position: 9",
                     kInText,
                     "joint \"knee\": default_position: expected a value in "
                     "[-1, 1], found 9"},
        BadCharacter{"body: \"leg\"", "body: \"toe\"", kInText,
                     "feet: expected a body of the model, found \"toe\""},
        BadCharacter{"body: \"leg\"", "body: \"leg\" geoms: \"hat\"", kInText,
                     "feet.geoms: expected colliding geoms of body \"leg\", "
                     "found \"hat\""},
        BadCharacter{"head_body: \"root\"", "head_body: \"hat\"", kInText,
                     "head_body: expected a body of the model, found \"hat\""},
        BadCharacter{"feet {", "tracked_bodies: \"leg\" feet {", kInText,
                     "tracked_bodies: expected the root \"root\" first"},
        BadCharacter{"feet {", "tracked_bodies: [\"root\", \"root\"] feet {",
                     kInText,
                     "tracked_bodies: expected each body once, found \"root\" "
                     "again"},
        BadCharacter{"feet {",
                     "tracked_bodies: \"root\" "
                     "termination_exempt_bodies: \"leg\" feet {",
                     kInText,
                     "termination_exempt_bodies: expected tracked bodies"},
        BadCharacter{"feet {",
                     "mirror_joints { left: \"knee\" right: \"hip\" sign: 1 } "
                     "feet {",
                     kInText,
                     "mirror_joints: expected joints of the character, found "
                     "\"hip\""},
        BadCharacter{"feet {",
                     "mirror_joints { left: \"knee\" right: \"knee\" } feet {",
                     kInText, "sign: expected +1 or -1, found 0"},
        BadCharacter{"feet {",
                     "mirror_bodies { left: \"leg\" right: \"arm\" } feet {",
                     kInText,
                     "mirror_bodies: expected a body of the model, found "
                     "\"arm\""}));

INSTANTIATE_TEST_SUITE_P(
    Model, CharacterError,
    ::testing::Values(
        BadCharacter{"<mujoco>", "<mujoc>", kInModel,
                     "m.xml: expected an MJCF model, found: "},
        BadCharacter{"<geom size=\"0.1\"/>", "<geom size=\"-1\"/>", kInModel,
                     "m.xml: expected a model that compiles, found: "},
        BadCharacter{"<freejoint/>", "", kInModel,
                     "model: expected one free joint, on the first body below "
                     "the world, found 0 free joints"},
        BadCharacter{"<worldbody>",
                     "<worldbody><body name=\"ball\"><freejoint/><geom "
                     "size=\"1\"/></body>",
                     kInModel, "expected one tree of bodies below the world"},
        BadCharacter{"<body name=\"leg\"", "<body", kInModel,
                     "m.xml: expected a name for every body, found none for "
                     "body 2 of 2"},
        BadCharacter{"type=\"hinge\"", "type=\"slide\"", kInModel,
                     "found \"knee\", which is no hinge"},
        BadCharacter{"<geom name=\"sole\"",
                     "<joint name=\"twist\"/><geom name=\"sole\"", kInModel,
                     "joints: expected every hinge of the model, found none "
                     "for \"twist\""},
        BadCharacter{"<geom name=\"sole\"",
                     "<joint name=\"push\" type=\"slide\"/><geom "
                     "name=\"sole\"",
                     kInModel,
                     "model: expected hinges only below the root, found joint "
                     "\"push\""},
        BadCharacter{"<geom name=\"sole\"",
                     "<geom contype=\"0\" conaffinity=\"0\" name=\"sole\"",
                     kInModel,
                     "feet: expected a body with colliding geoms, found "
                     "\"leg\""}));

TEST(Character, NamesAPhysicsFieldOutOfRange) {
  v1::Physics physics = MakePhysics();
  physics.set_friction(-1);

  EXPECT_THAT(Character::Load("humanoid", physics),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "recipe field physics.friction: expected > 0, found "
                       "-1"));
}

}  // namespace
}  // namespace sinew::character
