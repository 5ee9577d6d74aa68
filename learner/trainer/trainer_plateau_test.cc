// The trainer's end at a plateau, and the clips that evaluations are judged by.

#include <cstdint>
#include <string>

#include "absl/strings/str_cat.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "learner/trainer/testing/trainer_rig.h"
#include "learner/trainer/trainer.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;

constexpr char kPlateau[] = "plateau { evaluations: 2 } ";

// Evaluations of snapshots 2, 4, 6, ... of which the first fails: the second is
// a gain, the fourth the second without one.
TEST(TrainerPlateau, IsReachedWhereTheEvaluationTakesEffect) {
  Rig run(MakeRecipe(kPlateau));

  for (int64_t iteration = 1; iteration <= 9; ++iteration) {
    const IterationReport report = run.Iterate();

    EXPECT_EQ(run.trainer->plateau_ends_it(), iteration == 9) << iteration;
    ASSERT_TRUE(report.plateau.has_value());
    EXPECT_EQ(report.plateau->best_share(), iteration < 5 ? 0 : 1);
    EXPECT_EQ(report.plateau->stalled(),
              iteration < 7 ? 0 : (iteration < 9 ? 1 : 2));
  }
  EXPECT_EQ(run.trainer->plateau().best_share(), 1);
}

// With plateau.anneal it is where annealing begins, and its end is the run's.
TEST(TrainerPlateau, LetsThePolicySettleFirst) {
  Rig plain(MakeRecipe(kPlateau));
  plain.Iterate(9);
  ASSERT_TRUE(plain.trainer->plateau_ends_it());
  const int64_t reached = plain.trainer->samples();
  const int64_t each = reached / 9;
  Rig run(MakeRecipe(absl::StrCat(
      "plateau { evaluations: 2 anneal: true } ppo { anneal { success_share: 0 "
      "samples: ",
      2 * each, " std_factor: 0.25 } } ")));

  run.Iterate(9);
  EXPECT_EQ(run.trainer->samples(), reached);
  EXPECT_TRUE(run.trainer->plateau().reached());
  EXPECT_FALSE(run.trainer->plateau_ends_it());
  EXPECT_EQ(run.Iterate().update.std_factor, 1);
  EXPECT_FALSE(run.trainer->plateau_ends_it());
  EXPECT_EQ(run.Iterate().update.std_factor, 0.5);
  EXPECT_TRUE(run.trainer->plateau_ends_it());
}

// Those of snapshots 2 and 4, which is what the policy was, count for nothing.
TEST(TrainerPlateau, IsLookedForOnceThePolicyLearns) {
  for (const int warmup : {4, 5}) {
    Rig run(MakeRecipe(absl::StrCat(
        kPlateau, "ppo { value_warmup_iterations: ", warmup, " }")));

    for (int64_t iteration = 1; iteration <= 11; ++iteration) {
      const IterationReport report = run.Iterate();

      EXPECT_EQ(run.trainer->plateau_ends_it(), iteration == 11)
          << iteration << ", " << warmup;
      EXPECT_EQ(report.plateau->best_share(), iteration < 7 ? 0 : 1)
          << iteration << ", " << warmup;
    }
  }
}

TEST(TrainerPlateau, IsNoneWhereTheRecipeHasNone) {
  Rig run(MakeRecipe());

  const IterationReport report = run.Iterate(9);

  EXPECT_FALSE(report.plateau.has_value());
  EXPECT_FALSE(run.trainer->plateau_ends_it());
  EXPECT_FALSE(run.trainer->Save().counters.has_plateau());
}

int64_t IterateToPlateau(Rig& run) {
  while (!run.trainer->plateau_ends_it() && run.trainer->iteration() < 20) {
    run.Iterate();
  }
  return run.trainer->iteration();
}

class TrainerPlateauResume : public ::testing::TestWithParam<const char*> {};

TEST_P(TrainerPlateauResume, ARunThatWasInterruptedEndsAtTheSameIteration) {
  const v1::Recipe recipe = MakeRecipe(absl::StrCat(kPlateau, GetParam()));
  Rig whole(recipe);
  const int64_t end = IterateToPlateau(whole);
  ASSERT_LT(end, 20);
  const std::string expected = Bits(whole.trainer->Save());
  Rig first(recipe);
  for (int64_t cut = 0; cut <= end; ++cut) {
    if (cut > 0) first.Iterate();

    Rig second(recipe);
    ASSERT_THAT(second.trainer->Restore(first.trainer->Save()), IsOk());
    // A run that was over is over at once.
    EXPECT_EQ(second.trainer->plateau_ends_it(), cut == end);
    EXPECT_EQ(IterateToPlateau(second), end) << "interrupted after " << cut;
    EXPECT_EQ(Bits(second.trainer->Save()), expected);
  }
}

INSTANTIATE_TEST_SUITE_P(Lags, TrainerPlateauResume,
                         ::testing::Values("", kLagOne,
                                           "evaluation { delay: 2 }"));

TEST(TrainerPlateau, IsForgottenOnAnotherLibrary) {
  const v1::Recipe recipe = MakeRecipe(kPlateau);
  Rig before(recipe);
  IterateToPlateau(before);
  v1::MotionLibrary library = MakeLibrary();
  library.mutable_clips(0)->set_num_frames(50);
  Rig after(recipe, 1, "others", library);

  ASSERT_THAT(after.trainer->Migrate(before.trainer->Save()), IsOk());

  EXPECT_FALSE(after.trainer->plateau_ends_it());
  EXPECT_FALSE(after.trainer->plateau().started());
}

TEST(Trainer, JudgesEvaluationsByTheClipsThatStartsAreDrawnFrom) {
  v1::MotionLibrary library = MakeLibrary();
  for (const char* name : {"run", "jump"}) {
    v1::ClipInfo& clip = *library.add_clips();
    clip = library.clips(0);
    clip.set_name(name);
  }
  library.mutable_clips(2)->set_left_out(true);
  Rig run(MakeRecipe("task { start { only_clips: 'walk' } }"), 1, "assets",
          library);

  const IterationReport report = run.Iterate(3);

  ASSERT_TRUE(report.evaluation.has_value());
  EXPECT_EQ(report.evaluation->overall.clips, 3);
  EXPECT_EQ(report.evaluation->training.clips, 2);
  EXPECT_EQ(report.drawn.clips, 1);
  EXPECT_EQ(report.drawn.starts, 3);
  EXPECT_EQ(report.curriculum.clips, 2);
  EXPECT_EQ(report.curriculum.drawn_clips, 1);
  const v1::CurriculumTable& table =
      run.trainer->snapshot().snapshot.curriculum();
  EXPECT_EQ(table.clips(1).evaluations(), 1);
  double drawn = 0;
  for (const auto& bin : table.bins()) {
    if (bin.clip() == 0) drawn += bin.probability();
  }
  EXPECT_DOUBLE_EQ(drawn, 1);
}

}  // namespace
}  // namespace sinew::learner
