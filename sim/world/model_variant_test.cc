#include "sim/world/model_variant.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_replace.h"
#include "common/files.h"
#include "common/testing/allocation_count.h"
#include "sim/world/testing/library_maker.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::world {
namespace {

// World, trunk, then the legs.
const std::vector<double> kScales = {1, 1.1, 0.85, 1, 1, 1};

class ModelVariantTest : public ::testing::Test {
 protected:
  // The toy with kScales in its file.
  std::unique_ptr<const character::Character> CompileAnew() const {
    const std::string folder = testing::NewFolder();
    const auto copy = [&](const std::string& name, const auto& replacements) {
      auto text = ReadFile(JoinPath(toy_.folder, name));
      EXPECT_TRUE(text.ok()) << text.status();
      EXPECT_TRUE(WriteFileAtomically(JoinPath(folder, name),
                                      absl::StrReplaceAll(*text, replacements))
                      .ok());
    };
    using Replacements = std::vector<std::pair<std::string, std::string>>;
    copy("toy.xml",
         Replacements{{"mass=\"6\"", "mass=\"6.6\""},
                      {"name=\"leg_fl\" fromto=\"0 0 0 0 0 -0.4\" mass=\"1\"",
                       "name=\"leg_fl\" fromto=\"0 0 0 0 0 -0.4\" "
                       "mass=\"0.85\""}});
    copy("character.textproto", Replacements{});
    auto character = character::Character::Load(
        JoinPath(folder, "character.textproto"), toy_.recipe.physics());
    EXPECT_TRUE(character.ok()) << character.status();
    return *std::move(character);
  }
  static Conditions Scaled(std::vector<double> scales, double friction = 1) {
    Conditions conditions;
    conditions.mass_scale = std::move(scales);
    conditions.friction_scale = friction;
    return conditions;
  }
  const mjModel* base() const { return toy_.character->model(); }

  testing::ToyWorld toy_ = testing::MakeToyWorld();
  ModelVariant variant_{*toy_.character};
};

void ExpectNear(const double* found, const double* expected, int count,
                const char* name) {
  for (int i = 0; i < count; ++i) {
    EXPECT_NEAR(found[i], expected[i], 1e-9 * std::abs(expected[i]) + 1e-15)
        << name << " " << i;
  }
}

TEST_F(ModelVariantTest, IsTheModelThatIsCompiledWithThoseMasses) {
  const auto compiled = CompileAnew();
  const mjModel* expected = compiled->model();
  Conditions conditions = Scaled(kScales);
  variant_.Compute(&conditions);
  const mjModel* found = variant_.Use(conditions);

  ASSERT_NEAR(expected->body_subtreemass[1], 6.6 + 0.85 + 3, 1e-12);
  const int bodies = 6, dofs = 10;
  ExpectNear(found->body_mass, expected->body_mass, bodies, "mass");
  ExpectNear(found->body_inertia, expected->body_inertia, 3 * bodies,
             "inertia");
  ExpectNear(found->body_subtreemass, expected->body_subtreemass, bodies,
             "subtreemass");
  ExpectNear(found->body_invweight0, expected->body_invweight0, 2 * bodies,
             "body_invweight0");
  ExpectNear(found->dof_invweight0, expected->dof_invweight0, dofs,
             "dof_invweight0");
  ExpectNear(found->dof_M0, expected->dof_M0, dofs, "dof_M0");
  ExpectNear(&found->stat.meaninertia, &expected->stat.meaninertia, 1,
             "meaninertia");
}

TEST_F(ModelVariantTest, MovesAsTheModelThatIsCompiledWithThoseMasses) {
  const auto compiled = CompileAnew();
  Conditions conditions = Scaled(kScales);
  variant_.Compute(&conditions);
  const mjModel* models[] = {variant_.Use(conditions), compiled->model(),
                             base()};
  std::vector<std::vector<double>> ends;
  for (const mjModel* model : models) {
    const character::DataPtr data(mj_makeData(model));
    data->qpos[2] = 0.6;
    data->qvel[3] = 1;
    data->qvel[7] = 2;
    for (int i = 0; i < 40; ++i) mj_step(model, data.get());
    ends.emplace_back(data->qpos, data->qpos + model->nq);
  }

  double moved = 0;
  for (int i = 0; i < 11; ++i) {
    EXPECT_NEAR(ends[0][i], ends[1][i], 1e-6) << i;
    moved = std::max(moved, std::abs(ends[1][i] - ends[2][i]));
  }
  EXPECT_GT(moved, 1e-4);  // the masses do matter
}

TEST_F(ModelVariantTest, DependsOnTheConditionsAlone) {
  Conditions first = Scaled(kScales, 0.7);
  variant_.Compute(&first);
  const std::vector<double> fields = first.model_fields;
  Conditions other = Scaled({1, 0.5, 2, 3, 1, 1});
  variant_.Compute(&other);
  variant_.Use(other);
  Conditions again = Scaled(kScales, 0.7);
  variant_.Compute(&again);

  EXPECT_EQ(again.model_fields, fields);
  EXPECT_NE(other.model_fields, fields);
}

TEST_F(ModelVariantTest, OfTheNominalBodyIsTheModelItself) {
  Conditions other = Scaled(kScales, 0.7);
  variant_.Compute(&other);
  variant_.Use(other);
  Conditions nominal = Scaled({1, 1, 1, 1, 1, 1});
  variant_.Compute(&nominal);
  const mjModel* found = variant_.Use(nominal);

  for (int b = 0; b < 6; ++b) {
    EXPECT_EQ(found->body_mass[b], base()->body_mass[b]);
    EXPECT_EQ(found->body_invweight0[2 * b], base()->body_invweight0[2 * b]);
  }
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(found->dof_M0[i], base()->dof_M0[i]);
  }
  EXPECT_EQ(found->stat.meaninertia, base()->stat.meaninertia);
}

TEST_F(ModelVariantTest, ScalesTheFrictionThatContactsHave) {
  Conditions slippery = Scaled({1, 1, 1, 1, 1, 1}, 0.5);
  variant_.Compute(&slippery);
  const mjModel* model = variant_.Use(slippery);
  const character::DataPtr data(mj_makeData(model));
  data->qpos[2] = 0.43;
  mj_forward(model, data.get());

  ASSERT_GT(data->ncon, 0);
  EXPECT_DOUBLE_EQ(data->contact[0].friction[0], 0.5);
}

TEST_F(ModelVariantTest, AllocatesTheFirstTimeOnly) {
  Conditions conditions = Scaled(kScales);
  variant_.Compute(&conditions);
  const int64_t before = sinew::testing::AllocationCount();

  conditions.mass_scale[1] = 1.3;
  variant_.Compute(&conditions);
  variant_.Use(conditions);

  EXPECT_EQ(sinew::testing::AllocationCount() - before, 0);
}

}  // namespace
}  // namespace sinew::world
