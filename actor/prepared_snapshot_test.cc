#include "actor/prepared_snapshot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "actor/testing/rollout_rig.h"
#include "common/config/recipe.h"
#include "common/testing/matchers.h"
#include "proto/sinew/v1/graph.pb.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::actor {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::RolloutRig;
using ::testing::SizeIs;

class PreparedSnapshotTest : public ::testing::Test {
 protected:
  explicit PreparedSnapshotTest(
      const v1::Recipe& recipe = world::testing::ToyRecipe())
      : rig_(recipe) {}

  // A graph of the rig.
  v1::Graph& Named(const std::string& name) {
    for (v1::Graph& graph : *rig_.message.mutable_graph()->mutable_graphs()) {
      if (graph.name() == name) return graph;
    }
    ADD_FAILURE() << "no graph " << name;
    return *rig_.message.mutable_graph()->add_graphs();
  }
  v1::Graph& Policy() { return Named("policy"); }
  v1::Tap& Action() {
    for (v1::Tap& tap : *Policy().mutable_taps()) {
      if (tap.name() == "action") return tap;
    }
    ADD_FAILURE() << "no tap \"action\"";
    return *Policy().add_taps();
  }
  absl::StatusOr<std::shared_ptr<const PreparedSnapshot>> Prepare() const {
    return PreparedSnapshot::Create(rig_.message, "digest", *rig_.assets);
  }

  RolloutRig rig_;
};

TEST_F(PreparedSnapshotTest, KnowsHowToTalkToTheGraph) {
  const auto snapshot = Prepare();

  ASSERT_THAT(snapshot, IsOk());
  const PolicyPorts& ports = (*snapshot)->policy().ports;
  EXPECT_EQ(ports.observation, "observation");
  EXPECT_THAT(ports.noise, ElementsAre("noise"));
  EXPECT_EQ(ports.action, "action");
  EXPECT_EQ(ports.mean, "mean");
  EXPECT_THAT((*snapshot)->policy().std,
              SizeIs(rig_.assets->task().action_width()));
  EXPECT_EQ((*snapshot)->teacher(), nullptr);
  EXPECT_EQ((*snapshot)->prior(), nullptr);
  EXPECT_EQ((*snapshot)->sha256(), "digest");
}

TEST_F(PreparedSnapshotTest, WithoutAGraphNamedPolicyIsInvalid) {
  Policy().set_name("prior");

  EXPECT_THAT(Prepare(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("\"policy\""), HasSubstr("[prior"))));
}

TEST_F(PreparedSnapshotTest, TakesAnActionWithoutDistributionBesideItsMean) {
  Action().clear_distribution();

  const auto snapshot = Prepare();

  ASSERT_THAT(snapshot, IsOk());
  EXPECT_EQ((*snapshot)->policy().ports.mean, "mean");
  EXPECT_EQ((*snapshot)->policy().ports.std_parameter, "");
  EXPECT_THAT((*snapshot)->policy().std, SizeIs(0));
}

TEST_F(PreparedSnapshotTest, NeedsATapNamedMeanWhereThereIsNoDistribution) {
  Action().clear_distribution();
  for (v1::Tap& tap : *Policy().mutable_taps()) {
    if (tap.name() == "mean") tap.set_name("average");
  }

  EXPECT_THAT(Prepare(), StatusIs(absl::StatusCode::kInvalidArgument,
                                  HasSubstr("expected a tap named mean beside "
                                            "action")));
}

TEST_F(PreparedSnapshotTest, NeedsAMeanAsWideAsTheAction) {
  Action().clear_distribution();
  for (v1::Tap& tap : *Policy().mutable_taps()) {
    if (tap.name() == "mean") tap.set_value("observation");
  }

  EXPECT_THAT(Prepare(), StatusIs(absl::StatusCode::kInvalidArgument,
                                  HasSubstr("expected tap mean of width 4")));
}

TEST_F(PreparedSnapshotTest, NeedsAnActionThatIsDecidedEveryStep) {
  Action().set_decision_period(2);

  EXPECT_THAT(Prepare(), StatusIs(absl::StatusCode::kInvalidArgument,
                                  HasSubstr("decided every step")));
}

TEST_F(PreparedSnapshotTest, NeedsATapOfTheMean) {
  auto& taps = *Policy().mutable_taps();
  const std::string mean = Action().gaussian().mean();
  for (int i = taps.size() - 1; i >= 0; --i) {
    if (taps[i].value() == mean) taps.DeleteSubrange(i, 1);
  }

  EXPECT_THAT(Prepare(), StatusIs(absl::StatusCode::kInvalidArgument,
                                  HasSubstr(", the mean of action")));
}

// With a recipe that lets the prior act.
class PriorSnapshotTest : public PreparedSnapshotTest {
 protected:
  PriorSnapshotTest()
      : PreparedSnapshotTest(WithDefaults(
            *ParseRecipe("task { action { placement: PLACEMENT_ABSOLUTE } }"
                         "distillation { prior_share: 0.5 }",
                         "test"))) {
    rig_.UseLatentPolicy();
  }
};

TEST_F(PriorSnapshotTest, ThePriorsActionIsItsMean) {
  const auto snapshot = Prepare();

  ASSERT_THAT(snapshot, IsOk());
  ASSERT_NE((*snapshot)->prior(), nullptr);
  const PolicyPorts& ports = (*snapshot)->prior()->ports;
  EXPECT_EQ(ports.observation, "self_observation");
  EXPECT_THAT(ports.noise, ElementsAre("noise"));
  EXPECT_EQ(ports.action, "action");
  EXPECT_EQ(ports.mean, "action");
  EXPECT_THAT((*snapshot)->prior()->std, SizeIs(0));
}

TEST_F(PriorSnapshotTest, ThePriorSeesTheBodysOwnStateAlone) {
  v1::Graph wide = Policy();
  wide.set_name("sample");
  Named("sample") = std::move(wide);

  EXPECT_THAT(Prepare(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("snapshot graph \"sample\": expected input "
                                 "observation of width")));
}

}  // namespace
}  // namespace sinew::actor
