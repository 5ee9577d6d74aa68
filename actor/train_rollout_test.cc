// Training orders.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mjxmacro.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <string>
#include <type_traits>
#include <vector>

#include "actor/rollout.h"
#include "actor/testing/order_allocations.h"
#include "actor/testing/rollout_rig.h"
#include "common/digest.h"
#include "common/segment/segment_layout.h"
#include "common/testing/matchers.h"
#include "sim/world/actuation.h"

namespace sinew::actor {
namespace {

using ::sinew::testing::StatusIs;
using testing::Bytes;
using testing::Column;
using ::testing::HasSubstr;
using testing::RolloutRig;

TEST(TrainRollout, FillsTheColumnsOfTheLayoutWithFiniteNumbers) {
  RolloutRig rig;
  const v1::Order order = rig.TrainOrder(/*environments=*/3, /*horizon=*/40);

  const v1::Segment segment = rig.Run(order);

  EXPECT_TRUE(CheckColumns(segment, rig.assets->layout(), /*steps=*/40, 3).ok())
      << CheckColumns(segment, rig.assets->layout(), 40, 3);
  EXPECT_TRUE(CheckColumnsFinite(segment).ok());
  EXPECT_EQ(segment.physics_steps(), 40 * 3 * 4);
  EXPECT_EQ(segment.end_states_size(), 3);
  EXPECT_EQ(segment.order_id(), order.order_id());
  EXPECT_EQ(segment.snapshot_sha256(), order.snapshot_sha256());
}

TEST(TrainRollout, GivesTheSameBytesAgainAndInAnotherWorker) {
  RolloutRig rig;

  rig.ExpectSameBytes(rig.TrainOrder(3, 40), /*other=*/rig.TrainOrder(2, 7));
}

// Fills every array of numbers that MuJoCo's data has with nonsense.
void Scribble(const mjModel* model, const mjData& data){
#undef MJ_M  // of mjxmacro.h: sizes as they are named
#define MJ_M(field) model->field
#define X(type, name, rows, columns)                                      \
  if constexpr (std::is_same_v<type, mjtNum>) {                           \
    std::memset(data.name, 0x7f, sizeof(type) * model->rows * (columns)); \
  }
#define XNV X
    MJDATA_POINTERS
#undef XNV
#undef X
#undef MJ_M
}

TEST(TrainRollout, GivesTheSameBytesAfterItsDataWasScribbledOver) {
  RolloutRig rig;
  const v1::Order order = rig.TrainOrder(3, 20);
  const std::string clean = Bytes(rig.Run(order));
  const mjModel* model = rig.assets->task().character().model();
  rig.worker->SetFrameObserver(
      [&](int, int, const mjData& data, absl::Span<const float>) {
        Scribble(model, data);
      });
  rig.Run(rig.EvaluationOrder({{1, 0, 5}}));

  EXPECT_EQ(Bytes(rig.Run(order)), clean);
}

TEST(TrainRollout, CutInTwoHalvesIsTheSameRollout) {
  RolloutRig rig;

  EXPECT_GT(rig.RunWholeAndInHalves(3, 60).episodes_size(), 3);
}

TEST(TrainRollout, GroupingOfEnvironmentsChangesNothing) {
  RolloutRig rig;
  const v1::Segment together = rig.Run(rig.TrainOrder(3, 30));
  for (int e = 0; e < 3; ++e) {
    v1::Order order = rig.TrainOrder(1, 30);
    order.set_first_environment(e);
    const v1::Segment alone = rig.Run(order);

    EXPECT_EQ(SerializeDeterministically(together.end_states(e)),
              SerializeDeterministically(alone.end_states(0)));
    const auto all = Column<float>(together, "reward");
    const auto own = Column<float>(alone, "reward");
    for (int t = 0; t < 30; ++t) EXPECT_EQ(all[t * 3 + e], own[t]) << t;
  }
}

TEST(TrainRollout, RecordedTargetsReplayWithoutPolicyAndReference) {
  RolloutRig rig;
  v1::Order order = rig.StandingOrder(1, 4);

  const v1::Segment segment = rig.Run(order);

  ASSERT_EQ(segment.episodes_size(), 0);
  const character::Character& character = rig.assets->task().character();
  const world::Actuation actuation(character, 4, /*ramp=*/false);
  const character::DataPtr data(mj_makeData(character.model()));
  mj_setState(character.model(), data.get(), order.states(0).physics().data(),
              mjSTATE_INTEGRATION);
  const auto targets = Column<double>(segment, "target");
  for (int t = 0; t < 4; ++t) {
    const auto target = absl::MakeConstSpan(targets).subspan(t * 4, 4);
    actuation.Run(target, target, data.get());
  }
  std::vector<double> row(segment.end_states(0).physics_size());
  mj_getState(character.model(), data.get(), row.data(), mjSTATE_INTEGRATION);
  EXPECT_THAT(segment.end_states(0).physics(),
              ::testing::ElementsAreArray(row));
}

TEST(TrainRollout, TheBoundaryIsWhatTheNextOrderSeesFirst) {
  RolloutRig rig;
  v1::Order order = rig.StandingOrder(1, 4);
  const v1::Segment first = rig.Run(order);
  v1::Order next = rig.TrainOrder(1, 1);
  *next.mutable_states() = first.end_states();
  ASSERT_FALSE(next.states(0).physics().empty());

  EXPECT_EQ(Column<float>(first, "boundary_observation"),
            Column<float>(rig.Run(next), "observation"));
}

TEST(TrainRollout, LogProbabilityIsThatOfTheGaussian) {
  RolloutRig rig;
  const v1::Segment segment = rig.Run(rig.TrainOrder(2, 3));

  rig.ExpectGaussianLogProbabilities(segment);
}

TEST(TrainRollout, NoiseIsStandardNormalTimesTheDeviation) {
  RolloutRig rig;
  const v1::Segment segment = rig.Run(rig.TrainOrder(3, 200));
  const auto action = Column<float>(segment, "action");
  const auto mean = Column<float>(segment, "action_mean");

  double sum = 0, squares = 0;
  for (size_t i = 0; i < action.size(); ++i) {
    const double z = (action[i] - mean[i]) / rig.std;
    sum += z;
    squares += z * z;
  }
  const auto count = static_cast<double>(action.size());  // 2400
  EXPECT_NEAR(sum / count, 0, 0.1);
  EXPECT_NEAR(squares / count, 1, 0.15);
}

TEST(TrainRollout, EpisodesAndFlagsTellTheSameStory) {
  RolloutRig rig;
  const v1::Segment segment = rig.Run(rig.TrainOrder(3, 80));
  const auto terminated = Column<uint8_t>(segment, "terminated");
  const auto truncated = Column<uint8_t>(segment, "truncated");
  const auto reward = Column<float>(segment, "reward");

  int at = 0;
  double sums[3] = {0, 0, 0};
  int steps[3] = {0, 0, 0};
  for (int i = 0; i < 80 * 3; ++i) {
    sums[i % 3] += reward[i];
    ++steps[i % 3];
    if (terminated[i] == 0 && truncated[i] == 0) continue;
    ASSERT_LT(at, segment.episodes_size());
    const v1::EpisodeEnd& end = segment.episodes(at++);
    EXPECT_EQ(end.environment(), i % 3);
    EXPECT_EQ(end.steps(), steps[i % 3]);
    EXPECT_NEAR(end.episode_return(), sums[i % 3], 1e-4);
    EXPECT_EQ(end.reason() == v1::EpisodeEnd::REASON_TERMINATED,
              terminated[i] == 1);
    sums[i % 3] = steps[i % 3] = 0;
  }
  EXPECT_EQ(at, segment.episodes_size());
  EXPECT_GT(Column<int32_t>(segment, "truncation_index").size(), 0u);
}

TEST(TrainRollout, ADivergedSimulationIsQuarantined) {
  RolloutRig rig;
  v1::Order order = rig.TrainOrder(3, 3);
  v1::EnvironmentState* state = order.mutable_states(1);
  *state = rig.StandingState();
  // time, qpos, then qvel: the root falls upwards at a million metres a second.
  state->set_physics(1 + 11 + 2, 1e6);
  const int64_t episode = state->episode();

  const v1::Segment segment = rig.Run(order);

  EXPECT_EQ(segment.diverged(), 1);
  EXPECT_TRUE(CheckColumns(segment, rig.assets->layout(), 3, 3).ok());
  EXPECT_TRUE(CheckColumnsFinite(segment).ok());
  const auto valid = Column<uint8_t>(segment, "valid");
  EXPECT_EQ(std::count(valid.begin(), valid.end(), 0), 1);
  EXPECT_EQ(valid[1], 0);
  EXPECT_EQ(Column<uint8_t>(segment, "terminated")[1], 1);
  EXPECT_EQ(Column<float>(segment, "reward")[1], 0);
  ASSERT_GE(segment.episodes_size(), 1);
  const auto diverged = std::find_if(
      segment.episodes().begin(), segment.episodes().end(), [](auto& end) {
        return end.reason() == v1::EpisodeEnd::REASON_DIVERGED;
      });
  ASSERT_NE(diverged, segment.episodes().end());
  EXPECT_EQ(diverged->episode(), episode);
  EXPECT_GT(segment.end_states(1).episode(), episode);
}

TEST(TrainRollout, LongerOrdersAllocateNoMoreThanShortOnes) {
  RolloutRig rig;

  EXPECT_EQ(testing::OrderAllocations(rig, 4),
            testing::OrderAllocations(rig, 12));
}

TEST(RolloutWorker, StopsWhenCancelled) {
  RolloutRig rig;
  const std::atomic<bool> cancel = true;

  EXPECT_THAT(
      rig.worker->Run(rig.TrainOrder(1, 5), *rig.snapshot, &cancel),
      StatusIs(absl::StatusCode::kCancelled, HasSubstr("was cancelled")));
}

}  // namespace
}  // namespace sinew::actor
