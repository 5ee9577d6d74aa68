#include "common/config/recipe.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/testing/matchers.h"

namespace sinew {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

v1::Recipe MakeRecipe() { return WithDefaults(v1::Recipe()); }

v1::Recipe MakeRecipe(const std::vector<std::string>& assignments) {
  v1::Recipe recipe = MakeRecipe();
  for (const std::string& assignment : assignments) {
    EXPECT_THAT(SetRecipeField(recipe, assignment), IsOk());
  }
  return recipe;
}

TEST(Recipe, WithDefaultsIsValid) {
  EXPECT_THAT(ValidateRecipe(MakeRecipe()), IsOk());
}

TEST(Recipe, KeepsWhatIsSetWhenFillingDefaults) {
  v1::Recipe recipe;
  recipe.mutable_ppo()->set_epochs(7);

  recipe = WithDefaults(recipe);

  EXPECT_EQ(recipe.ppo().epochs(), 7);
  EXPECT_EQ(recipe.ppo().discount(), 0.95);
}

TEST(Recipe, SurvivesPrintingAndParsing) {
  const v1::Recipe recipe = MakeRecipe({"seed=5", "task.action.ramp=true"});

  auto parsed = ParseRecipe(PrintRecipe(recipe), "config.textproto");

  ASSERT_THAT(parsed, IsOk());
  EXPECT_EQ(PrintRecipe(*parsed), PrintRecipe(recipe));
}

TEST(Recipe, NamesFileLineAndUnknownField) {
  EXPECT_THAT(
      ParseRecipe("name: \"x\"\nppo { epoch: 2 }", "my.textproto"),
      StatusIs(absl::StatusCode::kInvalidArgument,
               ::testing::AllOf(HasSubstr("my.textproto:2:"),
                              HasSubstr("no field named \"epoch\""))));
}

TEST(SetRecipeField, SetsScalarsListsEnumsAndStrings) {
  const v1::Recipe recipe =
      MakeRecipe({"network.policy_hidden=[512, 256]", "task.start.rule=bins",
                  "device=cuda", "ppo.policy_learning_rate=1e-3"});

  EXPECT_THAT(recipe.network().policy_hidden(), ElementsAre(512, 256));
  EXPECT_EQ(recipe.task().start().rule(), v1::Start::RULE_BINS);
  EXPECT_EQ(recipe.device(), "cuda");
  EXPECT_EQ(recipe.ppo().policy_learning_rate(), 1e-3);
}

TEST(SetRecipeField, NamesAnUnknownPathAndTheKnownFields) {
  v1::Recipe recipe = MakeRecipe();

  EXPECT_THAT(SetRecipeField(recipe, "ppo.epoch=3"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       ::testing::AllOf(HasSubstr("no recipe field \"epoch\""),
                                      HasSubstr("epochs"))));
  EXPECT_THAT(SetRecipeField(recipe, "ppo.epochs=many"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("--set ppo.epochs")));
  EXPECT_THAT(SetRecipeField(recipe, "ppo=3"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("expected a field inside the group")));
  EXPECT_THAT(SetRecipeField(recipe, "seed"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("expected path=value")));
}

struct Violation {
  std::string assignment;
  std::string expected;
};

class RecipeViolation : public ::testing::TestWithParam<Violation> {};

TEST_P(RecipeViolation, IsRefusedByNameOfField) {
  EXPECT_THAT(ValidateRecipe(MakeRecipe({GetParam().assignment})),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr(GetParam().expected)));
}

INSTANTIATE_TEST_SUITE_P(
    All, RecipeViolation,
    ::testing::Values(
        Violation{"task.action.scale=-1",
                  "task.action.scale: expected > 0, found -1"},
        Violation{"task.action.scale=nan", "task.action.scale: expected > 0"},
        Violation{"physics.physics_hz=100",
                  "a multiple of physics.control_hz (30), found 100"},
        Violation{"rollouts.environments=100",
                  "a multiple of rollouts.environments_per_order (8)"},
        Violation{"ppo.minibatch=3000", "a divisor of the batch of 8192"},
        Violation{"ppo.shards=3", "a divisor of ppo.minibatch (2048)"},
        Violation{"rollouts.max_policy_lag=2", "within [0, 1], found 2"},
        Violation{"rollouts.max_policy_lag=1",
                  "evaluation.delay: expected >= 2"},
        Violation{"ppo.anneal.success_share=0.5",
                  "evaluation.interval: expected > 0"},
        Violation{"ppo.discount=1", "within (0, 1), found 1"},
        Violation{"device=tpu", "expected \"cpu\" or \"cuda\""},
        Violation{"format_version=2", "format_version: expected 1, found 2"},
        Violation{"task.observation.frames_ahead=[0]",
                  "task.observation.frames_ahead: expected >= 1"}));

TEST(Recipe, RefusesFeedForwardAwayFromTheReference) {
  EXPECT_THAT(ValidateRecipe(MakeRecipe({"task.action.placement=absolute",
                                         "task.action.torque_feedforward=true"})),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("task.action.torque_feedforward")));
}

}  // namespace
}  // namespace sinew
