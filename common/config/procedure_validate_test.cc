// Trainings in stages in ValidateRecipe and WithDefaults: plateau, procedure,
// composer.

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

using ::sinew::testing::EqualsProto;
using ::sinew::testing::IsOk;
using ::sinew::testing::MakeRecipe;
using ::sinew::testing::StatusIs;
using ::sinew::testing::Violation;
using ::testing::ElementsAre;

// The least that a procedure needs, and more.
v1::Recipe MakeProcedure(const std::vector<std::string>& more = {}) {
  std::vector<std::string> assignments = {
      "evaluation.interval=10", "plateau.evaluations=3",
      "procedure.full_samples=1000", "procedure.hard_samples=500"};
  assignments.insert(assignments.end(), more.begin(), more.end());
  return MakeRecipe(assignments);
}

TEST(Stages, AreAbsentFromARecipeThatDoesNotAskForThem) {
  const v1::Recipe recipe = MakeRecipe({});

  EXPECT_FALSE(recipe.has_plateau());
  EXPECT_FALSE(recipe.has_procedure());
  EXPECT_FALSE(recipe.network().has_composer());
}

TEST(Stages, FillTheDefaultsOfAProcedure) {
  const v1::Recipe recipe = MakeProcedure();

  EXPECT_THAT(recipe.plateau(), EqualsProto("evaluations: 3 gain: 0.01"));
  EXPECT_THAT(
      recipe.procedure(),
      EqualsProto("max_primitives: 2 learnable_share: 0.1 full_samples: 1000 "
                  "hard_samples: 500 composer_hidden: 256 "
                  "composer_hidden: 256"));
  EXPECT_FALSE(recipe.network().has_composer());
  EXPECT_THAT(ValidateRecipe(recipe), IsOk());
  EXPECT_THAT(WithDefaults(recipe), EqualsProto(recipe));
}

TEST(Stages, KeepWhatIsSetWhenFillingDefaults) {
  const v1::Recipe recipe = MakeProcedure(
      {"plateau.gain=0", "procedure.learnable_share=0",
       "procedure.max_primitives=4", "procedure.composer_hidden=64",
       "procedure.recovery_samples=300", "procedure.composer_samples=200",
       "task.recovery.fallen_share=0.3"});

  EXPECT_EQ(recipe.plateau().gain(), 0);
  EXPECT_EQ(recipe.procedure().learnable_share(), 0);
  EXPECT_EQ(recipe.procedure().max_primitives(), 4);
  EXPECT_THAT(recipe.procedure().composer_hidden(), ElementsAre(64));
  EXPECT_THAT(ValidateRecipe(recipe), IsOk());
}

TEST(Stages, FillTheLayersOfAComposer) {
  const v1::Recipe recipe = MakeRecipe({"network.composer.primitives=3"});

  EXPECT_THAT(recipe.network().composer(),
              EqualsProto("primitives: 3 hidden: 256 hidden: 256"));
  EXPECT_THAT(ValidateRecipe(recipe), IsOk());
  EXPECT_THAT(WithDefaults(recipe), EqualsProto(recipe));
}

TEST(Stages, APlateauOfNoEvaluationsNeedsNone) {
  EXPECT_THAT(ValidateRecipe(MakeRecipe({"plateau.gain=0.02"})), IsOk());
}

class StageViolation : public ::testing::TestWithParam<Violation> {};

TEST_P(StageViolation, IsRefusedByNameOfField) {
  EXPECT_THAT(ValidateRecipe(MakeRecipe(GetParam().assignments)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       absl::StrCat("recipe field ", GetParam().expected)));
}

INSTANTIATE_TEST_SUITE_P(
    PlateauAndComposer, StageViolation,
    ::testing::Values(
        Violation{{"plateau.evaluations=3"},
                  "evaluation.interval: expected >= 1, since plateau waits for "
                  "evaluations, found 0"},
        Violation{{"plateau.evaluations=-1"},
                  "plateau.evaluations: expected >= 0, found -1"},
        Violation{{"plateau.gain=1.5"},
                  "plateau.gain: expected within [0, 1], found 1.5"},
        Violation{{"plateau.gain=nan"},
                  "plateau.gain: expected within [0, 1], found nan"},
        Violation{{"plateau.min_samples=-5"},
                  "plateau.min_samples: expected >= 0, found -5"},
        Violation{{"network.composer.primitives=1"},
                  "network.composer.primitives: expected within [2, 16], found "
                  "1"},
        Violation{{"network.composer.hidden=64"},
                  "network.composer.primitives: expected within [2, 16], found "
                  "0"},
        Violation{{"network.composer.primitives=17"},
                  "network.composer.primitives: expected within [2, 16], found "
                  "17"},
        Violation{
            {"network.composer.primitives=3", "network.composer.hidden=[64,0]"},
            "network.composer.hidden: expected within [1, 16384], found 0"}));

class ProcedureViolation : public ::testing::TestWithParam<Violation> {};

TEST_P(ProcedureViolation, IsRefusedByNameOfField) {
  EXPECT_THAT(ValidateRecipe(MakeProcedure(GetParam().assignments)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       absl::StrCat("recipe field ", GetParam().expected)));
}

INSTANTIATE_TEST_SUITE_P(
    Ranges, ProcedureViolation,
    ::testing::Values(
        Violation{{"procedure.max_primitives=16"},
                  "procedure.max_primitives: expected within [1, 15], found "
                  "16"},
        Violation{{"procedure.max_primitives=-1"},
                  "procedure.max_primitives: expected within [1, 15], found "
                  "-1"},
        Violation{{"procedure.negligible_clips=-1"},
                  "procedure.negligible_clips: expected >= 0, found -1"},
        Violation{{"procedure.learnable_share=1.5"},
                  "procedure.learnable_share: expected within [0, 1], found "
                  "1.5"},
        Violation{{"procedure.learnable_share=nan"},
                  "procedure.learnable_share: expected within [0, 1], found "
                  "nan"},
        Violation{{"procedure.full_samples=0"},
                  "procedure.full_samples: expected > 0, found 0"},
        Violation{{"procedure.hard_samples=-7"},
                  "procedure.hard_samples: expected > 0, found -7"},
        Violation{{"procedure.recovery_samples=-1"},
                  "procedure.recovery_samples: expected >= 0, found -1"},
        Violation{{"procedure.composer_samples=-1"},
                  "procedure.composer_samples: expected >= 0, found -1"},
        Violation{{"procedure.composer_hidden=20000"},
                  "procedure.composer_hidden: expected within [1, 16384], "
                  "found 20000"}));

INSTANTIATE_TEST_SUITE_P(
    Together, ProcedureViolation,
    ::testing::Values(
        Violation{{"plateau.evaluations=0"},
                  "plateau.evaluations: expected >= 1, since stages of the "
                  "procedure end at a plateau, found 0"},
        Violation{{"evaluation.interval=0"},
                  "evaluation.interval: expected >= 1, since plateau waits for "
                  "evaluations, found 0"},
        Violation{{"procedure.recovery_samples=100"},
                  "task.recovery: expected fallen_share + far_share + "
                  "get_up_share > 0, since "
                  "procedure.recovery_samples asks for a recovery primitive, "
                  "found 0"},
        Violation{
            {"procedure.composer_samples=100", "procedure.max_primitives=1"},
            "procedure.composer_samples: expected 0, since one primitive "
            "alone cannot be composed, found 100"},
        Violation{
            {"procedure.rehearsal_share=0.5", "task.start.only_clips=[walk]"},
            "procedure.rehearsal_share: expected 0, since it would "
            "rehearse clips that are not among task.start.only_clips, "
            "found 0.5"},
        Violation{{"plateau.anneal=true", "plateau.evaluations=0"},
                  "plateau.anneal: expected false, since plateau.evaluations "
                  "is 0, found true"},
        Violation{{"procedure.rehearsal_share=1"},
                  "procedure.rehearsal_share: expected [0, 1), found 1"},
        Violation{{"procedure.environments_per_clip=-1"},
                  "procedure.environments_per_clip: expected within [0, "
                  "1048576], found -1"},
        Violation{{"network.composer.primitives=3"},
                  "network.composer: expected unset, since the procedure makes "
                  "its composer itself, found \"set\""}));

TEST(Stages, AShareOfOtherClipsNeedsClipsThatTheyAreOtherThan) {
  v1::Recipe recipe = MakeRecipe({});
  v1::Start& start = *recipe.mutable_task()->mutable_start();
  start.set_other_clips_share(0.25);
  EXPECT_THAT(ValidateRecipe(recipe),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "recipe field task.start.other_clips_share: expected 0, "
                       "since task.start.only_clips names none, found 0.25"));

  start.add_only_clips("walk");
  EXPECT_THAT(ValidateRecipe(recipe), IsOk());
  start.set_other_clips_share(1);
  EXPECT_THAT(ValidateRecipe(recipe),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "recipe field task.start.other_clips_share: expected "
                       "[0, 1), found 1"));
}

TEST(Stages, ARecipeFromAFileMayNotNameAClipOfNoName) {
  v1::Recipe recipe = MakeRecipe({});
  recipe.mutable_task()->mutable_start()->add_only_clips("");

  EXPECT_THAT(ValidateRecipe(recipe),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "recipe field task.start.only_clips: expected names of "
                       "clips, found \"\""));
}

}  // namespace
}  // namespace sinew
