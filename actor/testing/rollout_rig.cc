#include "actor/testing/rollout_rig.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "actor/zero_action.h"
#include "common/check.h"
#include "common/config/recipe.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/policy/builder.h"
#include "common/policy/latent_builder.h"
#include "common/policy/safetensors.h"
#include "common/policy/teacher_graph.h"
#include "common/segment/state_limits.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "sim/world/fallen_states.h"
#include "sim/world/testing/task_rig.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::actor::testing {
namespace {

using ::sinew::testing::IsOk;

std::map<std::string, std::string> AssetBytes(
    const world::testing::ToyWorld& toy) {
  const auto read = [&](const std::string& name) {
    return ReadFile(JoinPath(toy.library_folder, name)).value();
  };
  return {{"character", toy.character->character_text()},
          {"model", toy.character->model_binary()},
          {"library", read("manifest.json")},
          {"frames", read("frames.safetensors")},
          {"recipe", PrintRecipe(toy.recipe)}};
}

}  // namespace

RolloutRig::RolloutRig(const v1::Recipe& recipe,
                       world::testing::ToyClips clips) {
  world::testing::ToyWorld toy = world::testing::MakeToyWorld(recipe, clips);
  asset_bytes = AssetBytes(toy);
  std::unique_ptr<const world::FallenStates> fallen =
      world::testing::MakeFallenStates(toy);
  if (fallen != nullptr) asset_bytes["fallen"] = fallen->Serialize();
  assets = RolloutAssets::FromParts(toy.recipe, std::move(toy.character),
                                    std::move(toy.library), std::move(fallen))
               .value();
  policy::TrackingPolicyOptions options;
  options.observation_width = assets->task().observation_width();
  options.action_width = assets->task().action_width();
  options.network = recipe.network();
  options.network.clear_policy_hidden();
  options.network.add_policy_hidden(16);
  options.network.set_last_layer_gain(0.3);
  options.network.set_initial_std(std);
  *message.mutable_graph() = policy::BuildTrackingPolicy(options).value();
  message.set_weights(
      SerializeSafetensors(policy::InitialWeights(options, 3).value()));
  Prepare();
  NewWorker();
}

void RolloutRig::Prepare() {
  snapshot =
      PreparedSnapshot::Create(
          message, Sha256Hex(SerializeDeterministically(message)), *assets)
          .value();
}

void RolloutRig::NewWorker() {
  worker = RolloutWorker::Create(assets, /*max_environments=*/4).value();
}

void RolloutRig::UseZeroAction() {
  message = ZeroActionSnapshot(assets->task().observation_width(),
                               assets->task().action_width(),
                               /*std=*/0.01)
                .value();
  Prepare();
}

void RolloutRig::UseLatentPolicy(bool keep_as_teacher) {
  const world::TrackingTask& task = assets->task();
  policy::LatentPolicyOptions options;
  options.self_observation_width = task.self_observation_width();
  options.observation_width = task.observation_width();
  options.action_width = task.action_width();
  options.network = task.recipe().network();
  options.network.set_last_layer_gain(0.3);
  options.network.set_initial_std(std);
  options.explores = RecordedLatentWidth(task.recipe()) > 0;
  v1::Latent& latent = *options.network.mutable_latent();
  latent.set_width(3);
  for (auto* hidden :
       {latent.mutable_encoder_hidden(), latent.mutable_prior_hidden(),
        latent.mutable_decoder_hidden()}) {
    hidden->Clear();
    hidden->Add(16);
  }
  latent.set_log_variance_low(-5);
  latent.set_log_variance_high(2);
  const v1::Snapshot before = message;
  v1::PolicyGraph graph = policy::BuildLatentPolicy(options).value();
  TensorMap weights = policy::InitialLatentWeights(options, 4).value();
  if (keep_as_teacher) {
    const TensorMap teacher =
        ParseSafetensors(before.weights(), "before").value();
    SINEW_CHECK(
        policy::AddTeacherGraph(before.graph(), teacher, graph, weights).ok());
  }
  *message.mutable_graph() = std::move(graph);
  message.set_weights(SerializeSafetensors(weights));
  Prepare();
}

void RolloutRig::SetParameter(const std::string& name, float value) {
  TensorMap weights = ParseSafetensors(message.weights(), "rig").value();
  for (float& element : weights.at(name).mutable_float32()) element = value;
  message.set_weights(SerializeSafetensors(weights));
  Prepare();
}

v1::Order RolloutRig::TrainOrder(int environments, int horizon) const {
  v1::Order order;
  order.set_run_id("run");
  order.set_order_id(7);
  order.set_kind(v1::Order::KIND_TRAIN);
  order.set_snapshot_version(snapshot->version());
  order.set_snapshot_sha256(snapshot->sha256());
  order.set_layout_sha256(assets->layout_sha256());
  order.set_seed(11);
  order.set_horizon(horizon);
  for (int e = 0; e < environments; ++e) order.add_states();
  return order;
}

v1::EnvironmentState RolloutRig::StandingState() const {
  const world::TrackingTask& task = assets->task();
  const mjModel* model = task.character().model();
  const character::DataPtr data(mj_makeData(model));
  std::vector<double> row(task.state_size()), target(task.action_width());
  world::Episode episode;
  episode.clip = 1;
  task.Reset(episode, nullptr, data.get(), absl::MakeSpan(target),
             task.MakeWorkspace().get());
  mj_getState(model, data.get(), row.data(), mjSTATE_INTEGRATION);
  v1::EnvironmentState state;
  state.set_episode(5);
  state.set_clip(1);
  state.mutable_physics()->Add(row.begin(), row.end());
  state.mutable_previous_target()->Add(target.begin(), target.end());
  return state;
}

v1::Order RolloutRig::StandingOrder(int environments, int horizon) const {
  v1::Order order = TrainOrder(environments, horizon);
  for (v1::EnvironmentState& state : *order.mutable_states()) {
    state = StandingState();
  }
  return order;
}

v1::Order RolloutRig::EvaluationOrder(const std::vector<Start>& starts) const {
  v1::Order order = TrainOrder(0, 0);
  order.set_kind(v1::Order::KIND_EVALUATE);
  for (const Start& start : starts) {
    v1::EvaluationStart* to = order.add_starts();
    to->set_clip(start.clip);
    to->set_start_frame(start.frame);
    to->set_steps(start.steps);
  }
  return order;
}

v1::Segment RolloutRig::Run(const v1::Order& order) {
  v1::Segment segment = worker->Run(order, *snapshot).value();
  // Whatever it was about, replay would keep it.
  EXPECT_THAT(CheckLimits(assets->limits()), IsOk());
  EXPECT_THAT(CheckSegment(segment, assets->limits()), IsOk());
  return segment;
}

void RolloutRig::ExpectSameBytes(const v1::Order& order,
                                 const v1::Order& other) {
  const std::string first = Bytes(Run(order));

  Run(other);
  EXPECT_EQ(Bytes(Run(order)), first);

  NewWorker();
  EXPECT_EQ(Bytes(Run(order)), first);
}

v1::Segment RolloutRig::RunWholeAndInHalves(int environments, int horizon) {
  const v1::Segment whole = Run(TrainOrder(environments, horizon));
  v1::Order half = TrainOrder(environments, horizon / 2);
  const v1::Segment first = Run(half);
  *half.mutable_states() = first.end_states();
  NewWorker();
  ExpectTogether(whole, first, Run(half));
  return whole;
}

void RolloutRig::ExpectTogether(const v1::Segment& whole,
                                const v1::Segment& first,
                                const v1::Segment& second) const {
  const auto data = [](const v1::Segment& segment, absl::string_view name) {
    return FindColumn(segment, name)->data();
  };
  for (const auto& column : assets->layout().columns()) {
    if (column.lead() != v1::SegmentLayout::LEAD_STEP) continue;
    const std::string& name = column.name();
    EXPECT_EQ(data(whole, name), data(first, name) + data(second, name))
        << name;
  }
  v1::Segment ends = first;
  ends.mutable_episodes()->MergeFrom(second.episodes());
  ASSERT_EQ(whole.episodes_size(), ends.episodes_size());
  for (int i = 0; i < ends.episodes_size(); ++i) {
    EXPECT_EQ(SerializeDeterministically(whole.episodes(i)),
              SerializeDeterministically(ends.episodes(i)))
        << i;
  }
  EXPECT_EQ(data(whole, column::kBoundaryObservation),
            data(second, column::kBoundaryObservation));
  ASSERT_EQ(whole.end_states_size(), second.end_states_size());
  for (int e = 0; e < whole.end_states_size(); ++e) {
    EXPECT_EQ(SerializeDeterministically(whole.end_states(e)),
              SerializeDeterministically(second.end_states(e)))
        << e;
  }
}

void RolloutRig::ExpectGaussianLogProbabilities(
    const v1::Segment& segment) const {
  const auto action = Column<float>(segment, column::kAction);
  const auto mean = Column<float>(segment, column::kActionMean);
  const auto log_probability = Column<float>(segment, column::kLogProbability);
  ASSERT_FALSE(log_probability.empty());
  const size_t width = action.size() / log_probability.size();
  for (size_t i = 0; i < log_probability.size(); ++i) {
    double density = 1;
    for (size_t j = width * i; j < width * (i + 1); ++j) {
      const double z = (action[j] - mean[j]) / std;
      density *= std::exp(-z * z / 2) / (std * std::sqrt(2 * std::numbers::pi));
      EXPECT_NE(z, 0);
    }
    EXPECT_NEAR(log_probability[i], std::log(density), 1e-4);
  }
}

std::string Bytes(v1::Segment segment) {
  segment.clear_seconds();
  return SerializeDeterministically(segment);
}

}  // namespace sinew::actor::testing
