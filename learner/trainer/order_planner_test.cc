#include "learner/trainer/order_planner.h"

#include <vector>

#include "absl/status/status.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

// 6 environments in groups of 2; 3 starts of 30, 40 and 20 steps.
OrderPlanner::Options MakeOptions() {
  OrderPlanner::Options options;
  options.run_id = "run";
  options.assets_sha256 = "assets";
  options.layout_sha256 = "layout";
  options.seed = 5;
  options.rollouts.set_environments(6);
  options.rollouts.set_environments_per_order(2);
  options.rollouts.set_horizon(16);
  for (const int steps : {30, 40, 20}) {
    options.evaluation_starts.emplace_back().set_steps(steps);
  }
  return options;
}

std::vector<v1::Segment> SegmentsOf(const std::vector<v1::Order>& orders) {
  std::vector<v1::Segment> segments;
  for (const v1::Order& order : orders) {
    v1::Segment& segment = segments.emplace_back();
    segment.set_order_id(order.order_id());
    for (int i = 0; i < order.states_size(); ++i) {
      segment.add_end_states()->set_episode(order.first_environment() + i);
    }
  }
  return segments;
}

TEST(OrderPlanner, CutsTheEnvironmentsIntoOrders) {
  OrderPlanner planner(MakeOptions());

  const auto orders = planner.PlanTraining(4, {3, "digest"});

  ASSERT_EQ(orders.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(orders[i].order_id(), 1 + i);
    EXPECT_EQ(orders[i].kind(), v1::Order::KIND_TRAIN);
    EXPECT_EQ(orders[i].iteration(), 4);
    EXPECT_EQ(orders[i].snapshot_version(), 3);
    EXPECT_EQ(orders[i].snapshot_sha256(), "digest");
    EXPECT_EQ(orders[i].seed(), 5u);
    EXPECT_EQ(orders[i].horizon(), 16);
    EXPECT_EQ(orders[i].first_environment(), 2 * i);
    EXPECT_EQ(orders[i].states_size(), 2);
  }
}

TEST(OrderPlanner, AnEvaluationRunsAsLongAsItsLongestStart) {
  OrderPlanner planner(MakeOptions());

  const auto orders = planner.PlanEvaluation(4, {4, "digest"});

  ASSERT_EQ(orders.size(), 2u);
  EXPECT_EQ(orders[0].kind(), v1::Order::KIND_EVALUATE);
  EXPECT_EQ(orders[0].starts_size(), 2);
  EXPECT_EQ(orders[0].horizon(), 40);
  EXPECT_EQ(orders[1].starts_size(), 1);
  EXPECT_EQ(orders[1].horizon(), 20);
  EXPECT_EQ(planner.next_order_id(), 3);
}

TEST(OrderPlanner, TheNextOrdersGoOnFromTheEndStates) {
  OrderPlanner planner(MakeOptions());
  const auto orders = planner.PlanTraining(0, {0, "digest"});

  ASSERT_THAT(planner.Absorb(orders, SegmentsOf(orders)), IsOk());

  const auto next = planner.PlanTraining(1, {1, "digest"});
  EXPECT_EQ(next[0].order_id(), 4);
  EXPECT_EQ(next[2].states(1).episode(), 5);
}

TEST(OrderPlanner, TakesNothingFromSegmentsThatDoNotFit) {
  OrderPlanner planner(MakeOptions());
  const auto orders = planner.PlanTraining(0, {0, "digest"});
  auto segments = SegmentsOf(orders);
  segments[2].mutable_end_states()->RemoveLast();

  EXPECT_THAT(planner.Absorb(orders, segments),
              StatusIs(absl::StatusCode::kInternal,
                       HasSubstr("order 3: expected 2 end states, found 1")));
  segments.pop_back();
  EXPECT_THAT(planner.Absorb(orders, segments),
              StatusIs(absl::StatusCode::kInternal,
                       HasSubstr("expected 3 segments, found 2")));

  EXPECT_EQ(planner.environments()[1].episode(), 0);
}

TEST(OrderPlanner, RestoresItsOwnNumberOfEnvironmentsOnly) {
  OrderPlanner planner(MakeOptions());
  std::vector<v1::EnvironmentState> states(6);
  states[3].set_step(9);

  ASSERT_THAT(planner.Restore(states, 71), IsOk());
  EXPECT_EQ(planner.PlanTraining(0, {})[1].states(1).step(), 9);
  EXPECT_EQ(planner.next_order_id(), 74);
  states.pop_back();
  EXPECT_THAT(planner.Restore(states, 71),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("expected 6 environments")));
}

}  // namespace
}  // namespace sinew::learner
