#include "learner/distillation/distillation_learner.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "common/policy/safetensors.h"
#include "common/segment/episode_actor.h"
#include "common/segment/mirror.h"
#include "common/testing/matchers.h"
#include "learner/distillation/testing/distillation_rig.h"
#include "learner/torch/runtime.h"
#include "learner/update/normaliser.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;
using ::testing::Each;

UpdateStatistics UpdateOnce(Learner& learner, int64_t iteration) {
  const std::vector<v1::Segment> segments = MakeVisited(iteration);
  auto statistics = learner.Update(SegmentPointers(segments), iteration);
  EXPECT_THAT(statistics.status(), IsOk());
  return statistics.ok() ? *statistics : UpdateStatistics();
}

// Mean action loss of the first update, and of the last of `updates`.
struct Progress {
  double first = 0, last = 0;
};
Progress Learn(const v1::Recipe& recipe, int updates) {
  SyntheticTeacher teacher;
  const auto learner = MakeStudentLearner(recipe, teacher);
  Progress progress;
  for (int i = 0; i < updates; ++i) {
    progress.last = UpdateOnce(*learner, i).distillation->action_loss;
    if (i == 0) progress.first = progress.last;
  }
  return progress;
}

TEST(DistillationLearner, LearnsWhatTheTeacherDoesThroughALatent) {
  const Progress progress = Learn(
      StudentRecipe("distillation { memory { rows: 1024 } "
                    "kl_weight: 0 kl_weight_final: 0 continuity_weight: 0 } "
                    "network { latent { log_variance_low: -9 "
                    "log_variance_high: -3 } }"),
      /*updates=*/80);

  EXPECT_LT(progress.last, progress.first / 10);
}

TEST(DistillationLearner, LearnsWhatTheTeacherDoesWithoutALatent) {
  const Progress progress =
      Learn(PlainStudentRecipe("distillation { memory { rows: 1024 } }"), 80);

  EXPECT_LT(progress.last, progress.first / 10);
}

TEST(DistillationLearner, LearnsFromThePrioritisedMemory) {
  const Progress progress =
      Learn(PlainStudentRecipe("distillation { memory { rows: 1024 selector: "
                               "SELECTOR_PRIORITISED } }"),
            80);

  EXPECT_LT(progress.last, progress.first / 5);
}

TEST(DistillationLearner, HasTheSameBitsWhateverTheNumberOfRanks) {
  for (const v1::Recipe& recipe :
       {StudentRecipe(), PlainStudentRecipe(),
        StudentRecipe("distillation { form: FORM_CODE "
                      "memory { selector: SELECTOR_PRIORITISED } }")}) {
    std::vector<std::string> bits;
    for (const int ranks : {1, 2, 3}) {
      SyntheticTeacher teacher;
      const auto learner = MakeStudentLearner(recipe, teacher, ranks);
      for (int i = 0; i < 3; ++i) UpdateOnce(*learner, i);
      bits.push_back(Bits(*learner));
    }
    EXPECT_THAT(bits, Each(bits[0]));
  }
}

TEST(DistillationLearner, LearnsInBfloat16WhereItIsAsked) {
  const v1::Recipe recipe =
      PlainStudentRecipe("distillation { bfloat16: true }");
  const absl::Status has_bfloat16 =
      CheckBfloat16(DetectCpu(), "cpu", "distillation.bfloat16");
  SyntheticTeacher teacher;
  if (!has_bfloat16.ok()) {
    EXPECT_EQ(
        DistillationLearner::Create(recipe, {.observation_width = kObservation,
                                             .self_observation_width = kOwn,
                                             .action_width = kAction,
                                             .annotator = &teacher,
                                             .layout = StudentLayout(),
                                             .action_scale = StudentScale()})
            .status(),
        has_bfloat16);
    return;
  }
  const auto rounded = MakeStudentLearner(recipe, teacher);
  const auto exact = MakeStudentLearner(PlainStudentRecipe(), teacher);
  ASSERT_EQ(Bits(*rounded), Bits(*exact));

  UpdateOnce(*rounded, 0);
  UpdateOnce(*exact, 0);

  EXPECT_NE(Bits(*rounded), Bits(*exact));
}

TEST(DistillationLearner, GoesOnAfterALoadAsIfItHadNotStopped) {
  const v1::Recipe recipe = StudentRecipe(
      "distillation { memory { selector: SELECTOR_PRIORITISED } "
      "kl_weight: 0.01 kl_anneal_end: 400 "
      "learning_rate_final: 5e-4 rate_anneal_end: 400 }");
  SyntheticTeacher teacher;
  const auto learner = MakeStudentLearner(recipe, teacher);
  for (int i = 0; i < 2; ++i) UpdateOnce(*learner, i);
  v1::TrainingState state;
  learner->SaveCounters(state);

  const auto resumed = MakeStudentLearner(recipe, teacher);
  ASSERT_THAT(
      resumed->Load(learner->SaveTensors(), state, learner->SaveChunks()),
      IsOk());

  EXPECT_EQ(Bits(*resumed), Bits(*learner));
  for (Learner* one : {static_cast<Learner*>(learner.get()),
                       static_cast<Learner*>(resumed.get())}) {
    UpdateOnce(*one, 2);
  }
  EXPECT_EQ(Bits(*resumed), Bits(*learner));
}

// Of 128 rows an iteration.
TEST(DistillationLearner, LearnsAtARateThatFallsWithTheRowsBefore) {
  SyntheticTeacher teacher;
  const auto learner = MakeStudentLearner(
      StudentRecipe("distillation { learning_rate_final: 5e-5 "
                    "rate_anneal_begin: 128 rate_anneal_end: 384 }"),
      teacher);

  EXPECT_EQ(UpdateOnce(*learner, 0).policy_learning_rate, 5e-3);
  EXPECT_EQ(UpdateOnce(*learner, 1).policy_learning_rate, 5e-3);
  EXPECT_NEAR(UpdateOnce(*learner, 2).policy_learning_rate, 5e-4, 1e-12);
  EXPECT_EQ(UpdateOnce(*learner, 3).policy_learning_rate, 5e-5);
}

TEST(DistillationLearner, GivesTheSameAfterAPrepareAsWithoutOne) {
  SyntheticTeacher teacher;
  const auto one = MakeStudentLearner(StudentRecipe(), teacher);
  const auto two = MakeStudentLearner(StudentRecipe(), teacher);
  const std::vector<v1::Segment> segments = MakeVisited(0);
  const std::string before = Bits(*one);

  ASSERT_THAT(one->Prepare(SegmentPointers(segments)), IsOk());
  EXPECT_EQ(Bits(*one), before);
  const int64_t asked = teacher.rows_seen;
  ASSERT_THAT(one->Update(SegmentPointers(segments), 0).status(), IsOk());
  EXPECT_EQ(teacher.rows_seen, asked);
  ASSERT_THAT(two->Update(SegmentPointers(segments), 0).status(), IsOk());

  EXPECT_EQ(Bits(*one), Bits(*two));
}

TEST(DistillationLearner, LearnsFromNothingThatWasPreparedForOtherSegments) {
  SyntheticTeacher teacher;
  const auto one = MakeStudentLearner(StudentRecipe(), teacher);
  const auto two = MakeStudentLearner(StudentRecipe(), teacher);
  const std::vector<v1::Segment> others = MakeVisited(5);

  ASSERT_THAT(one->Prepare(SegmentPointers(others)), IsOk());
  UpdateOnce(*one, 0);
  UpdateOnce(*two, 0);

  EXPECT_EQ(Bits(*one), Bits(*two));
}

TEST(DistillationLearner, AsksAgainForWhatItPreparedBeforeALoad) {
  SyntheticTeacher teacher;
  const auto learner = MakeStudentLearner(StudentRecipe(), teacher);
  v1::TrainingState state;
  learner->SaveCounters(state);
  const std::vector<v1::Segment> segments = MakeVisited(0);
  ASSERT_THAT(learner->Prepare(SegmentPointers(segments)), IsOk());
  ASSERT_THAT(
      learner->Load(learner->SaveTensors(), state, learner->SaveChunks()),
      IsOk());

  UpdateOnce(*learner, 0);

  EXPECT_EQ(teacher.calls, 2);
}

TEST(DistillationLearner, ShowsTheTeacherValidRowsAloneInOneCall) {
  SyntheticTeacher teacher;
  const auto learner = MakeStudentLearner(StudentRecipe(), teacher);

  const UpdateStatistics statistics = UpdateOnce(*learner, 0);

  EXPECT_EQ(teacher.rows_seen, statistics.samples);
  EXPECT_LT(statistics.samples, 16 * kHorizon);
  EXPECT_EQ(teacher.calls, 1);
}

TEST(DistillationLearner, SaysWhatAnUpdateDid) {
  SyntheticTeacher teacher;
  const auto learner = MakeStudentLearner(
      StudentRecipe("distillation { kl_weight: 0.01 kl_weight_final: 0.001 "
                    "kl_anneal_end: 256 }"),
      teacher);

  const UpdateStatistics first = UpdateOnce(*learner, 0);
  const UpdateStatistics second = UpdateOnce(*learner, 1);

  ASSERT_TRUE(first.distillation && second.distillation);
  // 128 rows an iteration: the KL's weight is halfway down in the second.
  EXPECT_DOUBLE_EQ(first.distillation->kl_weight, 0.01);
  EXPECT_DOUBLE_EQ(second.distillation->kl_weight, 0.0055);
  EXPECT_EQ(first.distillation->memory_rows, 128);
  EXPECT_EQ(second.distillation->memory_rows, 256);
  EXPECT_EQ(first.distillation->labelled_rows, first.samples);
  EXPECT_GT(first.distillation->action_loss, 0);
  EXPECT_GT(first.distillation->action_error_rad, 0);
  EXPECT_GT(first.distillation->latent_kl, 0);
  EXPECT_GT(first.distillation->continuity_loss, 0);
  EXPECT_FLOAT_EQ(first.reward_mean, 0.5);
  EXPECT_EQ(first.non_finite, 0);
  EXPECT_GT(first.flops, 0);
}

TEST(DistillationLearner, PutsTheStatisticsOfItsRowsIntoTheNormalisers) {
  SyntheticTeacher teacher;
  for (const v1::Recipe& recipe : {StudentRecipe(), PlainStudentRecipe()}) {
    const auto learner = MakeStudentLearner(recipe, teacher);
    for (int i = 0; i < 4; ++i) UpdateOnce(*learner, i);

    // Rows are of N(3, 2^2); about 480 of them.
    for (const auto& [name, tensor] : learner->weights()) {
      const bool is_mean = name.ends_with("/mean") && name[0] == 'n';
      if (!is_mean && !name.ends_with("/inverse_std")) continue;
      for (const float value : tensor.float32()) {
        EXPECT_NEAR(value, is_mean ? 3 : 0.5, is_mean ? 0.4 : 0.08) << name;
      }
    }
  }
}

TEST(DistillationLearner, NormalisesByMirrorImagesAsWell) {
  SyntheticTeacher teacher;
  SegmentMirror mirror;
  for (int i = 0; i < kObservation; ++i) {
    mirror.observation.source.push_back(i);
    mirror.observation.sign.push_back(i == 0 ? -1 : 1);
  }
  mirror.action = {.source = {1, 0}, .sign = {1, 1}};
  const auto learner =
      MakeStudentLearner(PlainStudentRecipe("distillation { mirror: true }"),
                         teacher, /*ranks=*/2, mirror);
  for (int i = 0; i < 4; ++i) UpdateOnce(*learner, i);

  // Rows are of N(3, 2^2); the mean of +x and -x is 0, of their squares 13.
  const TensorMap weights = learner->weights();
  const auto mean = weights.at("normaliser/mean").float32();
  const auto inverse_std = weights.at("normaliser/inverse_std").float32();
  EXPECT_NEAR(mean[0], 0, 1e-5);
  EXPECT_NEAR(inverse_std[0], 1 / std::sqrt(13), 0.05);
  EXPECT_NEAR(mean[1], 3, 0.4);
  EXPECT_NEAR(inverse_std[1], 0.5, 0.08);
}

TEST(DistillationLearner, NormalisesByOthersRowsThanThoseOfThePrior) {
  const v1::Recipe recipe = StudentRecipe("distillation { prior_share: 0.5 }");
  SyntheticTeacher teacher;
  const auto learner = MakeStudentLearner(recipe, teacher);
  std::vector<v1::Segment> segments =
      MakeVisited(0, {.terminated_share = 0, .invalid_share = 0});
  int64_t expected = 0, environment = 0;
  for (v1::Segment& segment : segments) {
    for (int e = 0; e < 4; ++e, ++environment) {
      segment.add_end_states()->set_episode(environment / 3);
      if (WhoActs(recipe.distillation(), recipe.seed(), environment,
                  environment / 3) != EpisodeActor::kPrior) {
        expected += kHorizon;
      }
    }
  }

  const auto updated = learner->Update(SegmentPointers(segments), 0);

  ASSERT_THAT(updated.status(), IsOk());
  EXPECT_EQ(updated->samples, 16 * kHorizon);
  v1::TrainingState state;
  learner->SaveCounters(state);
  EXPECT_EQ(state.normaliser_count(), expected);
  EXPECT_GT(expected, 0);
  EXPECT_LT(expected, 16 * kHorizon);
}

TEST(DistillationLearner, BeginsWithTheWeightsOfAnother) {
  SyntheticTeacher teacher;
  const auto learner = MakeStudentLearner(StudentRecipe(), teacher);
  UpdateOnce(*learner, 0);
  const auto other = MakeStudentLearner(StudentRecipe("seed: 8"), teacher);

  ASSERT_THAT(other->InitFrom(learner->weights()), IsOk());

  EXPECT_EQ(SerializeSafetensors(other->weights()),
            SerializeSafetensors(learner->weights()));
  v1::TrainingState state;
  other->SaveCounters(state);
  EXPECT_EQ(state.normaliser_count(), kInheritedRows);

  const auto third = MakeStudentLearner(
      StudentRecipe("distillation { inherited_rows: 1e9 }"), teacher);
  ASSERT_THAT(third->InitFrom(learner->weights()), IsOk());
  third->SaveCounters(state);
  EXPECT_EQ(state.normaliser_count(), 1e9);
}

}  // namespace
}  // namespace sinew::learner
