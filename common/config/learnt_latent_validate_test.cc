// Latents that PPO learns, in ValidateRecipe and WithDefaults.

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/config/recipe.h"
#include "common/config/testing/recipe_assignments.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::MakeRecipe;
using ::sinew::testing::StatusIs;
using ::sinew::testing::Violation;

// A student with a latent, which is distilled.
const std::vector<std::string> kStudent = {"distillation.learning_rate=5e-4",
                                           "network.latent.width=32",
                                           "task.action.placement=absolute"};

// A latent that PPO learns, and more.
v1::Recipe MakeLearntLatent(const std::vector<std::string>& more = {}) {
  std::vector<std::string> assignments = {"network.latent.width=8",
                                          "task.action.placement=absolute"};
  assignments.insert(assignments.end(), more.begin(), more.end());
  return MakeRecipe(assignments);
}

TEST(LearntLatent, NeedsNoTeacherAndHasAWeightOfItsKl) {
  const v1::Recipe recipe = MakeLearntLatent();

  EXPECT_THAT(ValidateRecipe(recipe), IsOk());
  EXPECT_EQ(recipe.ppo().latent_kl_weight(), 0.001);
  EXPECT_EQ(RecordedLatentWidth(recipe), 8);
  EXPECT_EQ(
      MakeLearntLatent({"ppo.latent_kl_weight=0"}).ppo().latent_kl_weight(), 0);
}

TEST(LearntLatent, LeavesOtherRecipesAsTheyWere) {
  for (const v1::Recipe& recipe : {MakeRecipe({}), MakeRecipe(kStudent)}) {
    EXPECT_EQ(RecordedLatentWidth(recipe), 0);
    EXPECT_FALSE(recipe.ppo().has_latent_kl_weight());
  }
}

class LearntLatentViolation : public ::testing::TestWithParam<Violation> {};

TEST_P(LearntLatentViolation, IsRefusedByNameOfField) {
  EXPECT_THAT(ValidateRecipe(MakeLearntLatent(GetParam().assignments)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       absl::StrCat("recipe field ", GetParam().expected)));
}

INSTANTIATE_TEST_SUITE_P(
    All, LearntLatentViolation,
    ::testing::Values(
        Violation{{"ppo.latent_kl_weight=-1"},
                  "ppo.latent_kl_weight: expected >= 0, found -1"},
        Violation{{"ppo.mirror=true"},
                  "ppo.mirror: expected unset, since network.latent is set and "
                  "its noise has no mirror image, found true"},
        Violation{{"network.composer.primitives=2"},
                  "network.composer: expected unset, since network.latent is "
                  "set, found \"set\""},
        Violation{{"procedure.full_samples=1000", "procedure.hard_samples=500",
                   "plateau.evaluations=3", "evaluation.interval=10"},
                  "procedure: expected unset, since network.latent is set, "
                  "found \"set\""},
        // As where it is distilled.
        Violation{{"task.action.placement=around_next_reference"},
                  "task.action.placement: expected PLACEMENT_AROUND_CURRENT or "
                  "PLACEMENT_ABSOLUTE, since the decoder of network.latent "
                  "sees no reference, found "
                  "\"PLACEMENT_AROUND_NEXT_REFERENCE\""},
        // Sizes of PPO's minibatches must fit again.
        Violation{{"ppo.minibatch=1000"},
                  "ppo.minibatch: expected a divisor of the batch "
                  "(rollouts.environments * rollouts.horizon = 8192), found "
                  "1000"}));

TEST(LearntLatent, ItsWeightIsRefusedWhereThereIsNone) {
  std::vector<std::string> student = kStudent;
  student.push_back("ppo.latent_kl_weight=0.01");
  for (const v1::Recipe& recipe :
       {MakeRecipe({"ppo.latent_kl_weight=0.01"}), MakeRecipe(student)}) {
    EXPECT_THAT(ValidateRecipe(recipe),
                StatusIs(absl::StatusCode::kInvalidArgument,
                         "recipe field ppo.latent_kl_weight: expected unset, "
                         "since PPO learns no network.latent, found 0.01"));
  }
}

}  // namespace
}  // namespace sinew
