#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/policy/safetensors.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "learner/trainer/testing/trainer_rig.h"
#include "learner/trainer/trainer.h"

// The trainer and its curriculum: what evaluations say, what is left out, and
// another library.

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

TEST(Trainer, SnapshotsCarryTheStartTable) {
  for (const bool bins : {false, true}) {
    Rig run(MakeRecipe(absl::StrCat(
        "task { start { rule: ", bins ? "RULE_BINS" : "RULE_UNIFORM",
        " bin_seconds: 0.5 } }")));

    run.Iterate(4);

    // Bins of 15 frames of 40: episodes begin and fail in the first.
    const v1::CurriculumTable& table =
        run.trainer->snapshot().snapshot.curriculum();
    ASSERT_EQ(table.bins_size(), 3);
    EXPECT_EQ(table.bins(0).visits(), 32);
    EXPECT_GT(table.bins(0).failures(), 0);
    if (bins) {
      EXPECT_NE(table.bins(0).probability(), 15.0 / 40);
    } else {
      EXPECT_DOUBLE_EQ(table.bins(0).probability(), 15.0 / 40);
    }
  }
}

TEST(Trainer, EpisodesOfTheTeacherSayNothingOfTheStudent) {
  v1::Recipe recipe = MakeRecipe();
  recipe.mutable_ppo()->clear_anneal();
  recipe.mutable_distillation()->set_teacher_share(1);
  Rig run(WithDefaults(recipe));

  run.Iterate(4);

  const v1::CurriculumTable& table =
      run.trainer->snapshot().snapshot.curriculum();
  ASSERT_EQ(table.bins_size(), 2);
  EXPECT_EQ(table.bins(0).visits(), 0);
  EXPECT_EQ(table.bins(0).failures(), 0);
}

TEST(Trainer, AnEvaluationIsInTheTableAtTheIterationWhereItTakesEffect) {
  Rig run(MakeRecipe());

  run.Iterate(2);  // one of snapshot 2 has begun
  EXPECT_EQ(run.trainer->curriculum().table().clips(0).evaluations(), 0);
  IterationReport report = run.Iterate();

  const v1::CurriculumTable& table =
      run.trainer->snapshot().snapshot.curriculum();
  EXPECT_EQ(table.clips(0).evaluations(), 1);
  EXPECT_TRUE(table.clips(0).failed_latest());
  EXPECT_EQ(table.clips(0).last_evaluated(), 2);
  EXPECT_EQ(report.curriculum.hard_clips, 1);
  EXPECT_EQ(report.curriculum.clips, 1);
  EXPECT_EQ(report.curriculum.bins, 2);  // 30 + 10 frames
  EXPECT_EQ(report.curriculum.entropy_share, 1);
  EXPECT_EQ(report.curriculum.floor_share, 1);

  report = run.Iterate(2);  // that of snapshot 4 succeeded
  EXPECT_EQ(run.trainer->curriculum().table().clips(0).failed_evaluations(), 1);
  EXPECT_EQ(report.curriculum.evaluated_clips, 1);
  EXPECT_EQ(report.curriculum.hard_clips, 0);
  EXPECT_EQ(report.curriculum.worst_success, 1);
}

// Two clips, of which the second is left out.
v1::MotionLibrary MakeSplitLibrary() {
  v1::MotionLibrary library = MakeLibrary();
  v1::ClipInfo& clip = *library.add_clips();
  clip = library.clips(0);
  clip.set_name("run");
  clip.set_left_out(true);
  return library;
}

TEST(Trainer, EvaluatesWhatIsLeftOutButDoesNotStartThere) {
  Rig run(MakeRecipe("task { start { rule: RULE_ADAPTIVE_BINS } }"), 1,
          "assets", MakeSplitLibrary());

  const IterationReport report = run.Iterate(3);

  ASSERT_TRUE(report.evaluation.has_value());
  EXPECT_EQ(report.evaluation->overall.clips, 2);
  EXPECT_EQ(report.evaluation->training.clips, 1);
  EXPECT_EQ(report.evaluation->left_out.clips, 1);
  const v1::CurriculumTable& table =
      run.trainer->snapshot().snapshot.curriculum();
  EXPECT_EQ(table.clips(1).evaluations(), 1);
  for (const auto& bin : table.bins()) EXPECT_EQ(bin.clip(), 0);
}

class TrainerMigration : public ::testing::TestWithParam<const char*> {};

// The library of before with a clip in front.
v1::MotionLibrary MakeLargerLibrary() {
  v1::MotionLibrary library;
  library.set_frames_per_second(30);
  v1::ClipInfo& added = *library.add_clips();
  added.set_name("jump");
  added.set_num_frames(61);
  *library.add_clips() = MakeLibrary().clips(0);
  return library;
}

TEST_P(TrainerMigration, GoesOnWithAnotherLibrary) {
  const v1::Recipe recipe = MakeRecipe(GetParam());
  Rig before(recipe, 1, "assets", MakeLibrary(), {"walk-digest"});
  before.Iterate(5);  // an evaluation of snapshot 4 may be out
  const Trainer::State state = before.trainer->Save();
  Rig after(recipe, 1, "others", MakeLargerLibrary(),
            {"jump-digest", "walk-digest"});
  EXPECT_THAT(after.trainer->Restore(state),
              StatusIs(absl::StatusCode::kFailedPrecondition));

  const auto adopted = after.trainer->Migrate(state);

  ASSERT_THAT(adopted, IsOk());
  EXPECT_EQ(*adopted, 1);
  EXPECT_EQ(after.trainer->iteration(), 5);
  EXPECT_EQ(after.trainer->samples(), before.trainer->samples());
  const Trainer::State migrated = after.trainer->Save();
  EXPECT_EQ(SerializeSafetensors(migrated.tensors),
            SerializeSafetensors(state.tensors));
  EXPECT_EQ(migrated.counters.open_orders_size(), 0);
  EXPECT_EQ(migrated.counters.pending_evaluations_size(), 0);
  EXPECT_TRUE(migrated.counters.environments(0).physics().empty());
  // What is known of "walk" has moved with it.
  const v1::CurriculumTable& table =
      after.trainer->snapshot().snapshot.curriculum();
  EXPECT_EQ(after.trainer->snapshot().snapshot.version(), 5);
  ASSERT_EQ(table.clips_size(), 2);
  EXPECT_EQ(table.clips(0).evaluations(), 0);
  EXPECT_EQ(table.clips(1).evaluations(),
            state.counters.curriculum().clips(0).evaluations());
  int64_t visits = 0;
  for (const auto& bin : table.bins()) visits += bin.clip() * bin.visits();
  EXPECT_EQ(visits, 5 * 8);  // all of them in clip 1

  // It trains on, and can be resumed as ever.
  after.Iterate();
  Rig resumed(recipe, 1, "others", MakeLargerLibrary(),
              {"jump-digest", "walk-digest"});
  ASSERT_THAT(resumed.trainer->Restore(after.trainer->Save()), IsOk());
  after.Iterate(2);
  resumed.Iterate(2);
  EXPECT_EQ(Bits(resumed.trainer->Save()), Bits(after.trainer->Save()));
}

INSTANTIATE_TEST_SUITE_P(
    Rules, TrainerMigration,
    ::testing::Values("", kLagOne,
                      "task { start { rule: RULE_ADAPTIVE_BINS } }"));

TEST(Trainer, ForgetsWhatStalledOnAnotherLibrary) {
  const v1::Recipe recipe = MakeRecipe();
  Rig before(recipe);
  before.Iterate();
  Trainer::State state = before.trainer->Save();
  state.counters.mutable_anneal()->set_best_survival(0.9);
  state.counters.mutable_anneal()->set_stalled(3);
  Rig after(recipe, 1, "others", MakeLargerLibrary());
  ASSERT_THAT(after.trainer->Migrate(state), IsOk());
  EXPECT_EQ(after.trainer->Save().counters.anneal().best_survival(), 0);
  EXPECT_EQ(after.trainer->Save().counters.anneal().stalled(), 0);

  // Once started it goes on.
  state.counters.mutable_anneal()->set_started(true);
  state.counters.mutable_anneal()->set_start_samples(5);
  Rig annealing(recipe, 1, "others", MakeLargerLibrary());
  ASSERT_THAT(annealing.trainer->Migrate(state), IsOk());
  const Trainer::State migrated = annealing.trainer->Save();
  EXPECT_TRUE(migrated.counters.anneal().started());
  EXPECT_EQ(migrated.counters.anneal().start_samples(), 5);
}

TEST(Trainer, MigratesToAnotherLibraryOnlyUnderTheSameRecipe) {
  Rig run(MakeRecipe());
  run.Iterate();
  Rig other(MakeRecipe("ppo { discount: 0.9 }"), 1, "others",
            MakeLargerLibrary());

  EXPECT_THAT(other.trainer->Migrate(run.trainer->Save()),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("training state: recipe (it has changed")));
}

}  // namespace
}  // namespace sinew::learner
