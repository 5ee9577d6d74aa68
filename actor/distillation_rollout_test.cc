// Rollouts of recipes that distil: bases, policies without distribution.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "actor/rollout.h"
#include "actor/testing/rollout_rig.h"
#include "actor/testing/student_rollout.h"
#include "common/digest.h"
#include "common/segment/segment_layout.h"
#include "common/testing/matchers.h"
#include "sim/motion/library.h"
#include "sim/world/tracking_task.h"

namespace sinew::actor {
namespace {

using ::sinew::testing::IsOk;
using testing::Column;
using ::testing::Each;
using testing::kAbsolute;
using testing::kJoints;
using testing::kOwnScale;
using testing::RolloutRig;
using testing::Rows;
using testing::StudentRecipe;

TEST(DistillationRollout, FillsTheColumnsOfItsLayout) {
  RolloutRig rig(StudentRecipe(kAbsolute));
  rig.UseLatentPolicy();

  const v1::Segment segment = rig.Run(rig.TrainOrder(3, 40));

  EXPECT_THAT(CheckColumns(segment, rig.assets->layout(), 40, 3), IsOk());
  EXPECT_THAT(CheckColumnsFinite(segment), IsOk());
  EXPECT_EQ(FindColumn(rig.Run(rig.TrainOrder(1, 1)), "base")->shape_size(), 3);
  EXPECT_EQ(FindColumn(RolloutRig().Run(RolloutRig().TrainOrder(1, 1)), "base"),
            nullptr);
}

TEST(DistillationRollout, BaseAndScaledActionMakeTheTarget) {
  RolloutRig rig(StudentRecipe());

  const Rows rows(rig.Run(rig.TrainOrder(3, 40)));

  EXPECT_EQ(rows.base, rows.teacher_base);  // the same law
  for (size_t i = 0; i < rows.size(); ++i) {
    EXPECT_NEAR(rows.target[i], rows.Made(rows.base, i, 0.2), 1e-12);
  }
}

TEST(DistillationRollout, IsARunWithoutDistillationThatTellsBases) {
  RolloutRig student(StudentRecipe());
  RolloutRig plain;
  student.UseZeroAction();
  plain.UseZeroAction();

  const v1::Segment labelled = student.Run(student.StandingOrder(1, 6));
  const v1::Segment segment = plain.Run(plain.StandingOrder(1, 6));

  // Bases are all that is added.
  EXPECT_EQ(labelled.columns_size(), segment.columns_size() + 2);
  for (const auto& column : segment.columns()) {
    EXPECT_EQ(FindColumn(labelled, column.name())->data(), column.data())
        << column.name();
  }
  const Rows rows(labelled);
  const auto action = Column<float>(segment, "action");
  const auto target = Column<double>(segment, "target");
  for (size_t i = 0; i < rows.size(); ++i) {
    const double scale = i % kJoints == 2 ? kOwnScale : 0.2;
    EXPECT_NEAR(target[i], rows.base[i] + scale * action[i], 1e-12);
  }
}

TEST(DistillationRollout, EachLawHasItsBase) {
  RolloutRig rig(StudentRecipe(kAbsolute));
  rig.UseLatentPolicy();

  const v1::Segment segment = rig.Run(rig.StandingOrder(1, 10));

  const Rows rows(segment);
  const auto frames = Column<int32_t>(segment, "frame");
  const auto clips = Column<int32_t>(segment, "clip");
  const world::TrackingTask& task = rig.assets->task();
  ASSERT_EQ(segment.episodes_size(), 0);
  for (size_t i = 0; i < rows.size(); ++i) {
    const size_t t = i / kJoints, j = i % kJoints;
    EXPECT_EQ(rows.base[i], task.character().joints()[j].default_position);
    EXPECT_EQ(rows.teacher_base[i],
              task.library().frame(clips[t], frames[t] + 1).joint_position[j]);
  }
}

TEST(DistillationRollout, BasesAreWhatTheWorldsVariantsMakeOfThem) {
  RolloutRig rig(
      StudentRecipe("action { placement: PLACEMENT_AROUND_CURRENT }"
                    "recovery { fallen_share: 0.4 far_share: 0.4 steps: 6"
                    "           fallen_states: 2 }"
                    "randomisation { mass: 0.2 joint_offset: 0.05 }"));
  rig.UseLatentPolicy();

  const v1::Segment segment = rig.Run(rig.TrainOrder(4, 60));

  const Rows rows(segment);
  const auto valid = Column<uint8_t>(segment, "valid");
  for (size_t i = 0; i < rows.size(); ++i) {
    if (valid[i / kJoints] == 0) continue;
    EXPECT_NEAR(rows.target[i], rows.Made(rows.base, i, 0.2), 1e-12);
  }
  EXPECT_THAT(CheckColumnsFinite(segment), IsOk());
}

TEST(DistillationRollout, APolicyWithALatentExploresWithoutLogProbability) {
  RolloutRig rig(StudentRecipe(kAbsolute));
  rig.UseLatentPolicy();

  const v1::Segment segment = rig.Run(rig.StandingOrder(2, 3));

  const Rows rows(segment);
  EXPECT_THAT(Column<float>(segment, "log_probability"), Each(0));
  EXPECT_EQ(rows.action, rows.mean);
  // One state, two noises.
  for (int j = 0; j < kJoints; ++j) {
    EXPECT_NE(rows.action[j], rows.action[kJoints + j]);
  }
}

TEST(DistillationRollout, ActionsHaveTheNoiseThatTheRecipeAsksFor) {
  RolloutRig plain(StudentRecipe());
  RolloutRig noisy(StudentRecipe("", "action_noise: 0.3"));
  plain.UseZeroAction();
  noisy.UseZeroAction();
  const Rows zero(plain.Run(plain.TrainOrder(4, 50)));

  const Rows rows(noisy.RunWholeAndInHalves(4, 50));

  EXPECT_THAT(zero.mean, Each(0));
  EXPECT_THAT(rows.mean, Each(0));
  double squares = 0;
  for (size_t i = 0; i < rows.size(); ++i) {
    EXPECT_LT(std::abs(zero.action[i]), 0.05);  // its own noise is of 0.01
    squares += rows.action[i] * rows.action[i];
    EXPECT_NEAR(rows.target[i], rows.Made(rows.base, i, 0.2), 1e-12);
  }
  // Of 800 numbers.
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(rows.size())), 0.3, 0.03);
  for (int j = 0; j < kJoints; ++j) {
    EXPECT_NE(rows.action[j], rows.action[kJoints + j]);
  }
}

TEST(DistillationRollout, NoiseIsOfTheStudentsOwnEpisodesAlone) {
  for (const std::string share : {"teacher_share: 1", "prior_share: 1"}) {
    RolloutRig plain(StudentRecipe(kAbsolute, share));
    RolloutRig noisy(StudentRecipe(kAbsolute, share + " action_noise: 0.3"));
    plain.UseLatentPolicy(/*keep_as_teacher=*/true);
    noisy.UseLatentPolicy(/*keep_as_teacher=*/true);

    EXPECT_EQ(Rows(plain.Run(plain.TrainOrder(2, 10))).target,
              Rows(noisy.Run(noisy.TrainOrder(2, 10))).target)
        << share;
  }
}

TEST(DistillationRollout, EvaluatesWithoutNoiseOnActions) {
  RolloutRig plain(StudentRecipe());
  RolloutRig noisy(StudentRecipe("", "action_noise: 0.3"));

  const v1::Segment expected = plain.Run(plain.EvaluationOrder({{0, 3, 20}}));
  const v1::Segment found = noisy.Run(noisy.EvaluationOrder({{0, 3, 20}}));

  EXPECT_GT(expected.results(0).sum_g_mpjpe_mm(), 0);
  EXPECT_EQ(found.results(0).sum_g_mpjpe_mm(),
            expected.results(0).sum_g_mpjpe_mm());
}

// Of two posteriors with one mean, whatever they are unsure about.
TEST(DistillationRollout, EvaluatesWithThePosteriorsMean) {
  RolloutRig rig(StudentRecipe(kAbsolute));
  rig.UseLatentPolicy();
  std::vector<std::string> results;
  std::vector<std::vector<float>> actions;
  for (const float log_variance : {-100.0F, 100.0F}) {
    rig.SetParameter("encoder/log_variance/bias", log_variance);
    rig.Run(rig.TrainOrder(2, 3));  // noise that must not be left over
    const v1::Segment segment =
        rig.Run(rig.EvaluationOrder({{1, 0, 19}, {0, 3, 20}}));
    results.push_back(SerializeDeterministically(segment.results(0)) +
                      SerializeDeterministically(segment.results(1)));
    actions.push_back(Column<float>(rig.Run(rig.TrainOrder(2, 3)), "action"));
  }

  EXPECT_EQ(results[0], results[1]);
  EXPECT_NE(actions[0], actions[1]);
}

}  // namespace
}  // namespace sinew::actor
