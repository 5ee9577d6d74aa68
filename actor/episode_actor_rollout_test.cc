// Rollouts in which not only the student acts: shares of episodes that teacher
// or prior lead (common/segment/episode_actor.h).

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "actor/rollout.h"
#include "actor/testing/order_allocations.h"
#include "actor/testing/rollout_rig.h"
#include "actor/testing/student_rollout.h"
#include "common/segment/episode_actor.h"
#include "common/testing/matchers.h"
#include "sim/world/tracking_task.h"

namespace sinew::actor {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using testing::Column;
using ::testing::Each;
using ::testing::HasSubstr;
using testing::kAbsolute;
using testing::kJoints;
using testing::RolloutRig;
using testing::Rows;
using testing::StudentRecipe;

// Episode of each row, of environments that all began with episode 0.
std::vector<int> EpisodeOfRows(const v1::Segment& segment, int environments) {
  const auto terminated = Column<uint8_t>(segment, "terminated");
  const auto truncated = Column<uint8_t>(segment, "truncated");
  std::vector<int> current(environments), rows;
  for (size_t i = 0; i < terminated.size(); ++i) {
    int& episode = current[i % environments];
    rows.push_back(episode);
    if (terminated[i] != 0 || truncated[i] != 0) ++episode;
  }
  return rows;
}

// Half of the episodes are the teacher's; scales tell who acted.
v1::Recipe SharedRecipe() {
  return StudentRecipe(kAbsolute,
                       "teacher_share: 0.5 teacher_action { scale: 0.4 }");
}

// So that all three act.
v1::Recipe RecipeOfThree() {
  return StudentRecipe(
      absl::StrCat(kAbsolute, "randomisation { mass: 0.2 joint_offset: 0.05 }"),
      "teacher_share: 0.3 prior_share: 0.4 teacher_action { scale: 0.4 }");
}

TEST(EpisodeActorRollout, GivesTheSameBytesAgainAndInAnotherWorker) {
  RolloutRig rig(RecipeOfThree());
  rig.UseLatentPolicy(/*keep_as_teacher=*/true);

  rig.ExpectSameBytes(rig.TrainOrder(3, 40), /*other=*/rig.TrainOrder(2, 7));
}

TEST(EpisodeActorRollout, CutInTwoHalvesIsTheSameRollout) {
  RolloutRig rig(RecipeOfThree());
  rig.UseLatentPolicy(/*keep_as_teacher=*/true);

  const v1::Segment whole = rig.RunWholeAndInHalves(3, 60);

  std::set<EpisodeActor> actors;
  std::set<v1::StartKind> kinds;
  for (const v1::EpisodeEnd& end : whole.episodes()) {
    actors.insert(WhoActs(RecipeOfThree().distillation(),
                          rig.TrainOrder(1, 1).seed(), end.environment(),
                          end.episode()));
    kinds.insert(end.start_kind());
  }
  EXPECT_EQ(actors.size(), 3);
  EXPECT_EQ(kinds.size(), 2);
}

// The first half ends where bodies have just been carried on.
TEST(EpisodeActorRollout, CutWhereABodyGoesOnItIsTheSameRollout) {
  RolloutRig rig(StudentRecipe(
      absl::StrCat(kAbsolute, "randomisation { mass: 0.2 joint_offset: 0.05 }"),
      "prior_share: 1 prior_steps: 5"));
  rig.UseLatentPolicy();
  v1::Order order = rig.StandingOrder(2, 20);
  const v1::Segment whole = rig.Run(order);
  order.set_horizon(10);
  const v1::Segment first = rig.Run(order);
  *order.mutable_states() = first.end_states();
  rig.NewWorker();

  for (const v1::EnvironmentState& state : first.end_states()) {
    EXPECT_EQ(state.start_kind(), v1::START_KIND_CARRIED);
    EXPECT_EQ(state.step(), 0);
    EXPECT_GT(state.physics_size(), 0);
  }
  rig.ExpectTogether(whole, first, rig.Run(order));
}

TEST(EpisodeActorRollout, TheTeacherActsByItsLawInItsEpisodesOnly) {
  RolloutRig rig(SharedRecipe());
  rig.UseLatentPolicy(/*keep_as_teacher=*/true);
  const v1::Order order = rig.TrainOrder(4, 80);

  const v1::Segment segment = rig.Run(order);

  const Rows rows(segment);
  const std::vector<int> episodes = EpisodeOfRows(segment, 4);
  std::set<bool> seen;
  for (size_t i = 0; i < rows.size(); ++i) {
    const size_t row = i / kJoints;
    const bool teacher =
        WhoActs(SharedRecipe().distillation(), order.seed(), row % 4,
                episodes[row]) == EpisodeActor::kTeacher;
    seen.insert(teacher);
    EXPECT_NEAR(rows.target[i],
                teacher ? rows.Made(rows.teacher_base, i, 0.4)
                        : rows.Made(rows.base, i, 0.2),
                1e-12)
        << i;
  }
  EXPECT_EQ(seen.size(), 2);
  EXPECT_THAT(Column<float>(segment, "log_probability"), Each(0));
}

TEST(EpisodeActorRollout, ATeacherThatAlwaysActsIsThePolicyThatItWas) {
  RolloutRig rig(StudentRecipe("", "teacher_share: 1"));
  rig.UseLatentPolicy(/*keep_as_teacher=*/true);
  RolloutRig alone(StudentRecipe());
  // Of noise that is lost in rounding.
  alone.SetParameter("policy/std", 1e-30F);

  const Rows rows(rig.Run(rig.TrainOrder(3, 30)));
  const Rows expected(alone.Run(alone.TrainOrder(3, 30)));

  EXPECT_EQ(rows.action, expected.action);
  EXPECT_EQ(rows.target, expected.target);
}

// The actions of an order after a parameter of the snapshot has changed.
std::vector<float> ActionsWith(const std::string& share,
                               const std::string& parameter) {
  RolloutRig rig(StudentRecipe(kAbsolute, share));
  rig.UseLatentPolicy();
  if (!parameter.empty()) rig.SetParameter(parameter, 0.3F);
  return Column<float>(rig.Run(rig.TrainOrder(2, 10)), "action");
}

TEST(EpisodeActorRollout, ThePriorChoosesTheLatentInItsEpisodes) {
  for (const bool prior : {false, true}) {
    const std::string share = prior ? "prior_share: 1" : "";
    const std::vector<float> actions = ActionsWith(share, "");
    EXPECT_EQ(ActionsWith(share, "encoder/mean/bias") != actions, !prior);
    EXPECT_EQ(ActionsWith(share, "encoder/log_variance/bias") != actions,
              !prior);
    EXPECT_EQ(ActionsWith(share, "prior/mean/bias") != actions, prior);
    EXPECT_EQ(ActionsWith(share, "prior/log_variance/bias") != actions, prior);
    EXPECT_NE(ActionsWith(share, "decoder/action/bias"), actions);
  }
}

TEST(EpisodeActorRollout, ThePriorActsByTheStudentsLawWhereverTheGoalIs) {
  RolloutRig rig(StudentRecipe(kAbsolute, "prior_share: 1 prior_noise: 0"));
  rig.UseLatentPolicy();
  v1::Order order = rig.StandingOrder(2, 1);
  // The same body, another frame of the clip: another goal.
  order.mutable_states(1)->set_start_frame(order.states(0).start_frame() + 9);

  const v1::Segment segment = rig.Run(order);

  const Rows rows(segment);
  for (int j = 0; j < kJoints; ++j) {
    EXPECT_EQ(rows.action[j], rows.action[kJoints + j]);
    EXPECT_NE(rows.action[j], 0);
  }
  EXPECT_EQ(rows.action, rows.mean);
  for (size_t i = 0; i < rows.size(); ++i) {
    EXPECT_NEAR(rows.target[i], rows.Made(rows.base, i, 0.2), 1e-12);
  }
  EXPECT_THAT(Column<float>(segment, "log_probability"), Each(0));
}

TEST(EpisodeActorRollout, ABodyThatThePriorLeftGoesOnFromTheNearestFrame) {
  for (const bool prior : {false, true}) {
    RolloutRig rig(StudentRecipe(
        kAbsolute, prior ? "prior_share: 1 prior_steps: 100" : ""));
    rig.UseLatentPolicy();

    // The clip ends after 19 steps.
    const v1::Segment segment = rig.Run(rig.StandingOrder(1, 20));

    ASSERT_EQ(segment.episodes_size(), 1);
    EXPECT_EQ(segment.episodes(0).start_kind(), v1::START_KIND_REFERENCE);
    const v1::EnvironmentState& end = segment.end_states(0);
    EXPECT_EQ(end.start_kind(),
              prior ? v1::START_KIND_CARRIED : v1::START_KIND_REFERENCE);
    EXPECT_EQ(end.step(), 1);
    // Own columns of s_19, before and after, but for the new reference: the
    // body is as it was wherever it is carried on.
    const auto observation = Column<float>(segment, "observation");
    const auto last = Column<float>(segment, "truncation_observation");
    const int width = rig.assets->task().observation_width();
    const int own = rig.assets->task().self_observation_width();
    ASSERT_EQ(last.size(), width);
    const auto* after = observation.data() + 19 * width;
    double worst = 0;
    for (int i = 0; i < own; ++i) {
      worst = std::max<double>(worst, std::abs(after[i] - last[i]));
    }
    if (prior) {
      EXPECT_LT(worst, 1e-5);
    } else {
      EXPECT_GT(worst, 1e-3);
    }
  }
}

TEST(EpisodeActorRollout, EpisodesOfThePriorAreCutOff) {
  RolloutRig rig(StudentRecipe(kAbsolute, "prior_share: 1 prior_steps: 4"));
  rig.UseLatentPolicy();

  const v1::Segment segment = rig.Run(rig.StandingOrder(2, 17));

  // From all frames on which bodies go on, 15 more can be followed.
  ASSERT_EQ(segment.episodes_size(), 8);
  for (const v1::EpisodeEnd& end : segment.episodes()) {
    EXPECT_EQ(end.steps(), 4);
    EXPECT_EQ(end.reason(), v1::EpisodeEnd::REASON_TIME_LIMIT);
  }
  EXPECT_EQ(segment.episodes(7).start_kind(), v1::START_KIND_CARRIED);
}

TEST(EpisodeActorRollout, EpisodesOfThePriorAreNotCutOffWhileBodiesRecover) {
  RolloutRig rig(StudentRecipe(
      absl::StrCat(kAbsolute,
                   "recovery { fallen_share: 1 steps: 6 fallen_states: 2 }"),
      "prior_share: 1 prior_steps: 2"));
  rig.UseLatentPolicy();

  const v1::Segment segment = rig.Run(rig.TrainOrder(2, 8));

  int fallen = 0;
  for (const v1::EpisodeEnd& end : segment.episodes()) {
    if (end.start_kind() != v1::START_KIND_FALLEN) continue;
    ++fallen;
    EXPECT_GT(end.steps(), 6);
  }
  EXPECT_GT(fallen, 0);
}

TEST(EpisodeActorRollout, ThePriorsNoiseHasAScale) {
  std::vector<std::vector<float>> actions;
  for (const char* noise : {"0", "0.001", "1"}) {
    RolloutRig rig(StudentRecipe(
        kAbsolute, absl::StrCat("prior_share: 1 prior_noise: ", noise)));
    rig.UseLatentPolicy();
    actions.push_back(
        Column<float>(rig.Run(rig.StandingOrder(2, 1)), "action"));
  }
  for (int j = 0; j < kJoints; ++j) {
    EXPECT_EQ(actions[0][j], actions[0][kJoints + j]);
    EXPECT_NE(actions[1][j], actions[1][kJoints + j]);
    EXPECT_NEAR(actions[1][j], actions[0][j], 0.01);
    EXPECT_NE(actions[2][j], actions[2][kJoints + j]);
  }
}

TEST(EpisodeActorRollout, GraphsThatNobodyUsesChangeNothing) {
  RolloutRig rig(StudentRecipe(kAbsolute));
  rig.UseLatentPolicy();
  RolloutRig more(StudentRecipe(kAbsolute));
  more.UseLatentPolicy(/*keep_as_teacher=*/true);

  const v1::Segment one = rig.Run(rig.TrainOrder(3, 20));
  const v1::Segment two = more.Run(more.TrainOrder(3, 20));

  EXPECT_EQ(more.snapshot->teacher(), nullptr);
  for (int i = 0; i < one.columns_size(); ++i) {
    EXPECT_EQ(one.columns(i).data(), two.columns(i).data())
        << one.columns(i).name();
  }
}

TEST(EpisodeActorRollout, TrainingNeedsThePriorThatShares) {
  RolloutRig rig(StudentRecipe(kAbsolute, "prior_share: 0.5"));

  EXPECT_THAT(rig.worker->Run(rig.TrainOrder(1, 5), *rig.snapshot),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("expected a snapshot with a graph "
                                 "\"sample\"")));
  EXPECT_THAT(rig.worker->Run(rig.EvaluationOrder({{1, 0, 5}}), *rig.snapshot),
              IsOk());
}

TEST(EpisodeActorRollout, TrainingNeedsTheTeacherThatShares) {
  RolloutRig rig(SharedRecipe());
  rig.UseLatentPolicy();

  EXPECT_THAT(rig.worker->Run(rig.TrainOrder(1, 5), *rig.snapshot),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("expected a snapshot with a graph "
                                 "\"teacher\"")));
  EXPECT_THAT(rig.worker->Run(rig.EvaluationOrder({{1, 0, 5}}), *rig.snapshot),
              IsOk());
}

class EpisodeActorAllocation : public ::testing::TestWithParam<const char*> {};

TEST_P(EpisodeActorAllocation, LongerOrdersAllocateNoMoreThanShortOnes) {
  RolloutRig rig(StudentRecipe(
      "", absl::StrCat(GetParam(), ": 1 teacher_action { scale: 0.1 }")));
  rig.UseLatentPolicy(/*keep_as_teacher=*/true);

  EXPECT_EQ(testing::OrderAllocations(rig, 4),
            testing::OrderAllocations(rig, 10));
}

INSTANTIATE_TEST_SUITE_P(Shares, EpisodeActorAllocation,
                         ::testing::Values("teacher_share",
                                           "prior_steps: 100 prior_share"));

}  // namespace
}  // namespace sinew::actor
