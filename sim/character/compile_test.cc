#include "sim/character/compile.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "sim/character/model_ptr.h"

namespace sinew::character {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

// A root with a leg, and what a model may bring along that training does not
// want. The box hangs across the leg at rest; the ball is out of its way.
constexpr char kModel[] = R"(<mujoco>
  <compiler angle="radian"/>
  <option timestep="0.01" integrator="implicitfast" solver="CG"/>
  <worldbody>
    <light pos="0 0 3"/><camera name="eye"/>
    <geom name="ground" type="plane" size="5 5 1" condim="1" friction="0.1"/>
    <geom name="wall" type="box" size="0.1 1 1" pos="3 0 1"/>
    <body name="root" pos="0 0 1"><freejoint/>
      <geom name="trunk" size="0.1"/>
      <geom name="badge" size="0.02" pos="0 1 0" contype="0" conaffinity="0"/>
      <body name="leg" pos="0 0 -0.3">
        <joint name="knee" axis="0 1 0" damping="7" armature="0.25"/>
        <geom name="shin" size="0.05"/>
        <body name="box" pos="0 0 -0.05">
          <joint name="ankle" axis="0 1 0"/><geom size="0.05"/>
          <body name="ball" pos="0 0.08 0.05">
            <joint name="toe" axis="0 1 0"/><geom size="0.05"/>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator><motor joint="knee"/></actuator>
  <sensor><jointpos joint="knee"/></sensor>
  <contact><pair geom1="trunk" geom2="shin"/></contact>
  <keyframe><key qpos="0 0 2 1 0 0 0 0 0 0"/></keyframe>
</mujoco>)";

v1::Character MakeCharacter() {
  v1::Character character;
  for (const char* name : {"knee", "ankle", "toe"}) {
    v1::Joint* joint = character.add_joints();
    joint->set_name(name);
    joint->set_damping(3);
  }
  return character;
}

ModelPtr CompileOrFail(const v1::Physics& physics,
                       Purpose purpose = Purpose::kPhysics,
                       const v1::Character& character = MakeCharacter()) {
  const std::string path = JoinPath(::testing::TempDir(), "compile_test.xml");
  EXPECT_THAT(WriteFileAtomically(path, kModel), IsOk());
  auto model = CompileModel(path, character, physics, purpose);
  EXPECT_THAT(model, IsOk());
  return *std::move(model);
}

int Geom(const mjModel& model, const char* name) {
  return mj_name2id(&model, mjOBJ_GEOM, name);
}

// Contacts between bodies that are not the world, in the rest pose.
int OwnContacts(const mjModel& model, double toe_angle) {
  const DataPtr data(mj_makeData(&model));
  const int toe = mj_name2id(&model, mjOBJ_JOINT, "toe");
  data->qpos[model.jnt_qposadr[toe]] = toe_angle;
  mj_forward(&model, data.get());
  int count = 0;
  for (int i = 0; i < data->ncon; ++i) {
    count += model.geom_bodyid[data->contact[i].geom[0]] != 0 &&
             model.geom_bodyid[data->contact[i].geom[1]] != 0;
  }
  return count;
}

TEST(CompileModel, AppliesTheRecipesOptions) {
  v1::Physics physics;
  physics.set_physics_hz(240);
  physics.set_solver_iterations(3);
  physics.set_line_search_iterations(4);
  physics.set_solver_tolerance(1e-4);
  const ModelPtr model = CompileOrFail(physics);

  EXPECT_DOUBLE_EQ(model->opt.timestep, 1.0 / 240);
  EXPECT_EQ(model->opt.integrator, mjINT_EULER);
  EXPECT_EQ(model->opt.solver, mjSOL_NEWTON);
  EXPECT_EQ(model->opt.cone, mjCONE_PYRAMIDAL);
  EXPECT_EQ(model->opt.iterations, 3);
  EXPECT_EQ(model->opt.ls_iterations, 4);
  EXPECT_EQ(model->opt.tolerance, 1e-4);
  EXPECT_NE(model->opt.disableflags & mjDSBL_ISLAND, 0);
  EXPECT_EQ(model->opt.disableflags & mjDSBL_EULERDAMP, 0);
}

TEST(CompileModel, RemovesWhatPhysicsDoesNotNeed) {
  const ModelPtr model = CompileOrFail(v1::Physics());

  EXPECT_EQ(model->nu, 0);
  EXPECT_EQ(model->nsensor, 0);
  EXPECT_EQ(model->nkey, 0);
  EXPECT_EQ(model->npair, 0);
  EXPECT_EQ(model->ncam, 0);
  EXPECT_EQ(model->nlight, 0);
  EXPECT_EQ(Geom(*model, "badge"), -1);
}

TEST(CompileModel, KeepsWhatIsSeenForPictures) {
  const ModelPtr model = CompileOrFail(v1::Physics(), Purpose::kPictures);

  EXPECT_GE(Geom(*model, "badge"), 0);
  EXPECT_EQ(model->nlight, 1);
  EXPECT_GE(model->geom_matid[Geom(*model, "ground")], 0);
}

TEST(CompileModel, PutsDampingAndArmatureOfTheCharacterIntoTheHinges) {
  v1::Character character = MakeCharacter();
  character.mutable_joints(1)->set_armature(0.5);
  const ModelPtr model =
      CompileOrFail(v1::Physics(), Purpose::kPhysics, character);

  const int knee =
      model->jnt_dofadr[mj_name2id(model.get(), mjOBJ_JOINT, "knee")];
  EXPECT_EQ(model->dof_damping[knee], 3);
  EXPECT_EQ(model->dof_armature[knee], 0.25);  // the model's own
  EXPECT_EQ(model->dof_armature[knee + 1], 0.5);
}

TEST(CompileModel, LetsTheFloorDecideOnFriction) {
  v1::Physics physics;
  physics.set_friction(0.7);
  const ModelPtr model = CompileOrFail(physics);
  const DataPtr data(mj_makeData(model.get()));
  data->qpos[2] = 0.05;  // the trunk in the ground
  mj_forward(model.get(), data.get());

  ASSERT_GT(data->ncon, 0);
  for (int i = 0; i < data->ncon; ++i) {
    EXPECT_EQ(data->contact[i].geom[0], Geom(*model, "ground"));
    EXPECT_EQ(data->contact[i].dim, 3);
    EXPECT_DOUBLE_EQ(data->contact[i].friction[0], 0.7);
  }
}

TEST(CompileModel, LetsContactlessGeomsTouchNothing) {
  v1::Character character = MakeCharacter();
  character.add_contactless_geoms("trunk");
  const ModelPtr model =
      CompileOrFail(v1::Physics(), Purpose::kPictures, character);
  const DataPtr data(mj_makeData(model.get()));
  data->qpos[2] = -0.02;  // the whole body is in the ground
  mj_forward(model.get(), data.get());

  ASSERT_GT(data->ncon, 0);
  for (int i = 0; i < data->ncon; ++i) {
    EXPECT_NE(data->contact[i].geom[1], Geom(*model, "trunk"));
  }
}

TEST(CompileModel, LetsContactlessGeomsWeighWhatTheyDo) {
  v1::Character character = MakeCharacter();
  character.add_contactless_geoms("trunk");
  character.add_contactless_geoms("shin");
  const ModelPtr with = CompileOrFail(v1::Physics());
  const ModelPtr without =
      CompileOrFail(v1::Physics(), Purpose::kPhysics, character);

  ASSERT_EQ(without->nbody, with->nbody);
  EXPECT_GT(with->body_mass[1], 0);
  for (int body = 0; body < with->nbody; ++body) {
    EXPECT_NEAR(without->body_mass[body], with->body_mass[body], 1e-9) << body;
    for (int i = 3 * body; i < 3 * body + 3; ++i) {
      EXPECT_NEAR(without->body_inertia[i], with->body_inertia[i], 1e-9)
          << body;
    }
  }
}

TEST(CompileModel, RefusesContactlessGeomsThatDoNotFit) {
  const std::pair<std::vector<const char*>, const char*> kCases[] = {
      {{"tail"}, "it does not have"},
      {{"badge"}, "touches nothing as it is"},
      {{"ground"}, "is the world's, not the body's"},
      {{"wall"}, "is the world's, not the body's"},
      {{"trunk", "shin", "trunk"}, "is listed twice"}};
  for (const auto& [names, why] : kCases) {
    v1::Character character = MakeCharacter();
    for (const char* name : names) character.add_contactless_geoms(name);
    const std::string path = JoinPath(::testing::TempDir(), "refused.xml");
    ASSERT_THAT(WriteFileAtomically(path, kModel), IsOk());

    EXPECT_THAT(
        CompileModel(path, character, v1::Physics(), Purpose::kPhysics),
        StatusIs(absl::StatusCode::kInvalidArgument,
                 HasSubstr(absl::StrCat(
                     "contactless_geoms: expected a colliding geom of ", path,
                     ", found \"", names.back(), "\", which ", why))));
  }
}

TEST(CompileModel, NamesNumbersThatMeanNothing) {
  const struct {
    const char *before, *after, *error;
  } kCases[] = {
      {"name=\"toe\" axis=\"0 1 0\"", "name=\"toe\" range=\"nan nan\"",
       "joint \"toe\": range: expected finite numbers, found nan"},
      {"name=\"toe\" axis=\"0 1 0\"", "name=\"toe\" range=\"2 -2\"",
       "joint \"toe\": range: expected a lower end and a higher one, found 2 "
       "-2"},
      {"name=\"toe\" axis=\"0 1 0\"", "name=\"toe\" axis=\"0 nan 0\"",
       "joint \"toe\": axis: expected finite numbers"},
      {"name=\"leg\" pos=\"0 0 -0.3\"", "name=\"leg\" pos=\"nan 0 0\"",
       "body \"leg\": pos: expected finite numbers, found nan"},
      {"name=\"shin\" size", "name=\"shin\" pos=\"0 inf 0\" size",
       "geom \"shin\": pos: expected finite numbers, found inf"}};
  for (const auto& [before, after, error] : kCases) {
    const std::string path = JoinPath(::testing::TempDir(), "numbers.xml");
    ASSERT_THAT(WriteFileAtomically(
                    path, absl::StrReplaceAll(kModel, {{before, after}})),
                IsOk());

    EXPECT_THAT(
        CompileModel(path, MakeCharacter(), v1::Physics(), Purpose::kPhysics),
        StatusIs(absl::StatusCode::kInvalidArgument,
                 HasSubstr(absl::StrCat(path, ": ", error))));
  }
}

TEST(CompileModel, LeavesBodiesApartUnlessAsked) {
  EXPECT_EQ(OwnContacts(*CompileOrFail(v1::Physics()), 0), 0);
}

TEST(CompileModel, ExcludesPairsThatOverlapAtRestFromSelfCollision) {
  v1::Physics physics;
  physics.set_self_collision(true);
  const ModelPtr model = CompileOrFail(physics);

  // At rest shin and ball overlap; that pair is excluded for good.
  EXPECT_EQ(model->nexclude, 1);
  EXPECT_EQ(OwnContacts(*model, 0), 0);
}

}  // namespace
}  // namespace sinew::character
