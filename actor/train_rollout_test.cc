#include "actor/rollout.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mjxmacro.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <string>
#include <type_traits>
#include <vector>

#include "actor/testing/rollout_rig.h"
#include "common/digest.h"
#include "common/segment/segment_layout.h"
#include "common/testing/allocation_count.h"
#include "common/testing/matchers.h"
#include "sim/world/actuation.h"

namespace sinew::actor {
namespace {

using ::sinew::testing::StatusIs;
using testing::Bytes;
using testing::Column;
using ::testing::Each;
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
  const v1::Order order = rig.TrainOrder(3, 40);
  const std::string first = Bytes(rig.Run(order));

  rig.Run(rig.TrainOrder(2, 7));  // other work in between
  EXPECT_EQ(Bytes(rig.Run(order)), first);

  rig.NewWorker();
  EXPECT_EQ(Bytes(rig.Run(order)), first);
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
      [&](int, int, const mjData& data) { Scribble(model, data); });
  rig.Run(rig.EvaluationOrder({{1, 0, 5}}));

  EXPECT_EQ(Bytes(rig.Run(order)), clean);
}

// Rows [from, from + count) of a step column.
std::string Rows(const v1::Segment& segment, absl::string_view name, int from,
                 int count) {
  const v1::Tensor* column = FindColumn(segment, name);
  const size_t row = column->data().size() / column->shape(0);
  return column->data().substr(from * row, count * row);
}

TEST(TrainRollout, CutInTwoHalvesIsTheSameRollout) {
  RolloutRig rig;
  const v1::Segment whole = rig.Run(rig.TrainOrder(3, 60));

  v1::Order half = rig.TrainOrder(3, 30);
  const v1::Segment first = rig.Run(half);
  *half.mutable_states() = first.end_states();
  rig.NewWorker();
  const v1::Segment second = rig.Run(half);

  ASSERT_GT(whole.episodes_size(), 3);
  for (const auto& column : rig.assets->layout().columns()) {
    if (column.lead() != v1::SegmentLayout::LEAD_STEP) continue;
    EXPECT_EQ(Rows(whole, column.name(), 0, 30),
              FindColumn(first, column.name())->data())
        << column.name();
    EXPECT_EQ(Rows(whole, column.name(), 30, 30),
              FindColumn(second, column.name())->data())
        << column.name();
  }
  for (int e = 0; e < 3; ++e) {
    EXPECT_EQ(SerializeDeterministically(whole.end_states(e)),
              SerializeDeterministically(second.end_states(e)));
  }
  EXPECT_EQ(whole.episodes_size(),
            first.episodes_size() + second.episodes_size());
  EXPECT_EQ(Column<float>(whole, "boundary_observation"),
            Column<float>(second, "boundary_observation"));
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
  v1::Order order = rig.TrainOrder(1, 4);
  *order.mutable_states(0) = rig.StandingState();

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
  v1::Order order = rig.TrainOrder(1, 4);
  *order.mutable_states(0) = rig.StandingState();
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
  const auto action = Column<float>(segment, "action");
  const auto mean = Column<float>(segment, "action_mean");
  const auto log_probability = Column<float>(segment, "log_probability");

  for (size_t i = 0; i < log_probability.size(); ++i) {
    double density = 1;
    for (size_t j = 0; j < 4; ++j) {
      const double z = (action[4 * i + j] - mean[4 * i + j]) / rig.std;
      density *=
          std::exp(-z * z / 2) / (rig.std * std::sqrt(2 * std::numbers::pi));
      EXPECT_NE(z, 0);
    }
    EXPECT_NEAR(log_probability[i], std::log(density), 1e-4);
  }
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
  v1::Order order = rig.TrainOrder(1, 4);
  *order.mutable_states(0) = rig.StandingState();
  const auto count = [&](int horizon) {
    order.set_horizon(horizon);
    rig.Run(order);
    const int64_t before = sinew::testing::AllocationCount();
    const v1::Segment segment = rig.Run(order);
    EXPECT_EQ(segment.episodes_size(), 0);
    return sinew::testing::AllocationCount() - before;
  };

  EXPECT_EQ(count(4), count(12));
}

TEST(Evaluation, SurvivesWhatCanBeDoneAndFailsWhatCannot) {
  RolloutRig rig;
  rig.UseZeroAction();

  const v1::Segment segment =
      rig.Run(rig.EvaluationOrder({{1, 0, 19}, {2, 0, 15}, {1, 5, 14}}));

  ASSERT_EQ(segment.results_size(), 3);
  EXPECT_EQ(segment.columns_size(), 0);
  const v1::EvaluationResult& standing = segment.results(0);
  EXPECT_TRUE(standing.success());
  EXPECT_EQ(standing.frames(), 19);
  EXPECT_EQ(standing.failed_at_frame(), -1);
  EXPECT_EQ(standing.velocity_frames(), 18);
  EXPECT_EQ(standing.acceleration_frames(), 17);
  EXPECT_LT(standing.sum_g_mpjpe_mm() / 19, 50);
  EXPECT_EQ(standing.sum_body_mm_size(), 5);
  const v1::EvaluationResult& tumble = segment.results(1);
  EXPECT_FALSE(tumble.success());
  EXPECT_EQ(tumble.frames(), tumble.failed_at_frame());
  EXPECT_LT(tumble.frames(), 15);
  EXPECT_GT(tumble.sum_g_mpjpe_mm(), 500);
  EXPECT_EQ(segment.results(2).start_frame(), 5);
}

TEST(Evaluation, BodySumsAddUpToTheMean) {
  RolloutRig rig;
  const v1::Segment segment = rig.Run(rig.EvaluationOrder({{0, 3, 30}}));

  double sum = 0;
  for (double body : segment.results(0).sum_body_mm()) sum += body;
  EXPECT_NEAR(sum / 5, segment.results(0).sum_g_mpjpe_mm(), 1e-9);
}

TEST(Evaluation, StartsAreIndependentOfEachOther) {
  RolloutRig rig;
  const std::vector<testing::Start> starts = {
      {0, 3, 30}, {2, 0, 15}, {0, 9, 8}};
  const v1::Segment together = rig.Run(rig.EvaluationOrder(starts));

  for (size_t i = 0; i < starts.size(); ++i) {
    const v1::Segment alone = rig.Run(rig.EvaluationOrder({starts[i]}));
    EXPECT_EQ(SerializeDeterministically(alone.results(0)),
              SerializeDeterministically(together.results(i)));
  }
}

TEST(Evaluation, DoesNotDependOnTheSeed) {
  RolloutRig rig;
  v1::Order order = rig.EvaluationOrder({{0, 3, 30}});
  const std::string first = Bytes(rig.Run(order));
  order.set_seed(order.seed() + 1);

  EXPECT_EQ(Bytes(rig.Run(order)), first);
}

TEST(Evaluation, ShowsEveryFrameToItsObserver) {
  RolloutRig rig;
  rig.UseZeroAction();
  std::vector<int> frames;
  rig.worker->SetFrameObserver([&](int start, int frame, const mjData& data) {
    EXPECT_EQ(start, 0);
    EXPECT_GT(data.xpos[5], 0.3);  // the trunk's height
    frames.push_back(frame);
  });

  rig.Run(rig.EvaluationOrder({{1, 0, 4}}));

  EXPECT_THAT(frames, ::testing::ElementsAre(1, 2, 3, 4));
}

TEST(RolloutWorker, StopsWhenCancelled) {
  RolloutRig rig;
  const std::atomic<bool> cancel = true;

  EXPECT_THAT(
      rig.worker->Run(rig.TrainOrder(1, 5), *rig.snapshot, &cancel),
      StatusIs(absl::StatusCode::kCancelled, HasSubstr("was cancelled")));
}

class RefusalTest : public ::testing::Test {
 protected:
  void ExpectRefused(const v1::Order& order, const char* message) {
    EXPECT_THAT(
        rig_.worker->Run(order, *rig_.snapshot),
        StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr(message)));
  }
  RolloutRig rig_;
};

TEST_F(RefusalTest, OfOrdersForOtherSnapshotsLayoutsAndKinds) {
  v1::Order order = rig_.TrainOrder(1, 5);
  order.set_layout_sha256("abc");
  ExpectRefused(order, "order 7 field layout_sha256: expected ");
  order = rig_.TrainOrder(1, 5);
  order.set_snapshot_version(4);
  ExpectRefused(order, "field snapshot_version: expected 0, found 4");
  order = rig_.TrainOrder(1, 5);
  order.set_snapshot_sha256("");
  ExpectRefused(order, "field snapshot_sha256: expected ");
  order.set_snapshot_sha256(rig_.snapshot->sha256());
  order.set_kind(v1::Order::KIND_UNSPECIFIED);
  ExpectRefused(order, "field kind: expected KIND_TRAIN or KIND_EVALUATE");
}

TEST_F(RefusalTest, OfSizesOutOfRange) {
  v1::Order order = rig_.TrainOrder(1, 0);
  ExpectRefused(order, "field horizon: expected >= 1, found 0");
  order = rig_.TrainOrder(5, 1);
  ExpectRefused(order, "field states: expected 1 to 4 environments, found 5");
  order = rig_.EvaluationOrder({});
  ExpectRefused(order, "field starts: expected 1 to 4, found 0");
}

TEST_F(RefusalTest, OfStatesThatDoNotFit) {
  v1::Order good = rig_.TrainOrder(1, 1);
  *good.mutable_states(0) = rig_.StandingState();
  v1::Order order = good;
  order.mutable_states(0)->mutable_physics()->RemoveLast();
  ExpectRefused(order, "order.states[0].physics: expected ");
  order = good;
  order.mutable_states(0)->set_physics(
      3, std::numeric_limits<double>::quiet_NaN());
  ExpectRefused(order, "order.states[0].physics[3]: expected a finite number");
  order = good;
  order.mutable_states(0)->clear_previous_target();
  ExpectRefused(order, "previous_target: expected 4 numbers, found 0");
  order = good;
  order.mutable_states(0)->set_clip(3);
  ExpectRefused(order, "order.states[0].clip: expected 0 to 2, found 3");
  order = good;
  order.mutable_states(0)->set_step(18);
  order.mutable_states(0)->set_start_frame(1);
  ExpectRefused(order, "order.states[0].step: expected 0 to 17, found 18");
  order = good;
  order.mutable_states(0)->set_episode(-1);
  ExpectRefused(order, "order.states[0].episode: expected >= 0, found -1");
}

TEST_F(RefusalTest, OfStartsOutsideTheirClip) {
  ExpectRefused(rig_.EvaluationOrder({{3, 0, 5}}),
                "starts[0].clip: expected 0 to 2, found 3");
  ExpectRefused(rig_.EvaluationOrder({{1, 19, 1}}),
                "starts[0].start_frame: expected 0 to 18, found 19");
  ExpectRefused(rig_.EvaluationOrder({{0, 0, 5}, {1, 10, 10}}),
                "starts[1].steps: expected 1 to 9, found 10");
}

}  // namespace
}  // namespace sinew::actor
