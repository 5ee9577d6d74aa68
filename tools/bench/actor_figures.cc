#include "tools/bench/actor_figures.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "actor/prepared_snapshot.h"
#include "actor/rollout.h"
#include "common/config/recipe.h"
#include "common/digest.h"
#include "common/policy/builder.h"
#include "common/policy/executor.h"
#include "common/policy/latent_builder.h"
#include "common/policy/safetensors.h"
#include "common/policy/validate.h"
#include "common/status_macros.h"
#include "common/thread_seconds.h"
#include "sim/world/tracking_task.h"
#include "tools/bench/quantile.h"
#include "tools/bench/raw_physics.h"

namespace sinew::bench {
namespace {

// One value per round.
struct Rounds {
  std::vector<double> ratio, rollout_rate, raw_rate, step_us, other_us,
      products_us;

  void Add(const Rounds& other) {
    for (auto member :
         {&Rounds::ratio, &Rounds::rollout_rate, &Rounds::raw_rate,
          &Rounds::step_us, &Rounds::other_us, &Rounds::products_us}) {
      (this->*member)
          .insert((this->*member).end(), (other.*member).begin(),
                  (other.*member).end());
    }
  }
};

// Graph "policy" of the recipe with its untrained weights.
struct Policy {
  v1::PolicyGraph graph;
  TensorMap weights;
};

// Of a recipe in which PPO learns a latent.
absl::StatusOr<Policy> UntrainedLatent(const actor::RolloutAssets& assets) {
  policy::LatentPolicyOptions options;
  options.self_observation_width = assets.task().self_observation_width();
  options.observation_width = assets.task().observation_width();
  options.action_width = assets.task().action_width();
  options.network = assets.recipe().network();
  options.network.set_initial_std(0.05);
  options.explores = true;
  Policy result;
  SINEW_ASSIGN_OR_RETURN(result.graph, policy::BuildLatentPolicy(options));
  SINEW_ASSIGN_OR_RETURN(result.weights,
                         policy::InitialLatentWeights(options, /*seed=*/1));
  return result;
}

absl::StatusOr<Policy> UntrainedPolicy(const actor::RolloutAssets& assets) {
  if (RecordedLatentWidth(assets.recipe()) > 0) return UntrainedLatent(assets);
  policy::TrackingPolicyOptions options;
  options.observation_width = assets.task().observation_width();
  options.action_width = assets.task().action_width();
  options.network = assets.recipe().network();
  options.network.set_initial_std(0.05);
  Policy result;
  SINEW_ASSIGN_OR_RETURN(result.graph, policy::BuildTrackingPolicy(options));
  SINEW_ASSIGN_OR_RETURN(result.weights,
                         policy::InitialWeights(options, /*seed=*/1));
  return result;
}

// A LINEAR node with its result as a tap; without `input` of one of its own.
void AddProduct(const v1::Node& node, const std::string& input, int64_t width,
                v1::Graph& graph) {
  v1::Node& product = *graph.add_nodes();
  product = node;
  product.set_inputs(0, input);
  if (input.empty()) {
    v1::GraphInput& own = *graph.add_inputs();
    own.set_name(absl::StrCat(node.name(), "/input"));
    own.set_width(width);
    own.set_kind(v1::GraphInput::KIND_DATA);
    product.set_inputs(0, own.name());
  }
  v1::Tap& tap = *graph.add_taps();
  tap.set_name(absl::StrCat(node.name(), "/result"));
  tap.set_value(node.name());
}

// The policy's LINEAR nodes alone, each of the result of the one before it in
// the graph: a composer's primitives all begin at the observation. One that
// reads several values joined, as a decoder does, has an input of its own.
absl::StatusOr<std::unique_ptr<policy::Executor>> ProductsAlone(
    const actor::RolloutAssets& assets, int batch) {
  SINEW_ASSIGN_OR_RETURN(Policy policy, UntrainedPolicy(assets));
  SINEW_ASSIGN_OR_RETURN(const v1::Graph* whole,
                         policy::FindGraph(policy.graph, "policy"));
  v1::Graph chains;
  chains.set_name("products");
  *chains.mutable_inputs() = whole->inputs();
  std::map<std::string, std::string> source;  // of a node, in `chains`
  std::map<std::string, int64_t> width;       // of those
  for (const v1::GraphInput& input : whole->inputs()) {
    source[input.name()] = input.name();
    width[input.name()] = input.width();
  }
  for (const v1::Node& node : whole->nodes()) {
    const std::string& input = source.at(node.inputs(0));
    source[node.name()] = node.op() == v1::OP_LINEAR ? node.name() : input;
    if (node.op() != v1::OP_LINEAR) continue;
    const std::vector<int64_t>& shape =
        policy.weights.at(node.parameters(0)).shape;
    AddProduct(node, width.at(input) == shape[1] ? input : "", shape[1],
               chains);
    width[node.name()] = shape[0];
  }
  v1::PolicyGraph graph;
  graph.set_format_version(1);
  *graph.add_graphs() = chains;
  *graph.mutable_parameters() = policy.graph.parameters();
  for (auto& [name, tensor] : policy.weights) {
    for (float& element : tensor.mutable_float32()) element = 0.01F;
  }
  SINEW_ASSIGN_OR_RETURN(
      auto pack, policy::PackWeights(graph, "products", policy.weights));
  return policy::Executor::Create(std::move(pack), batch);
}

// A thread's part: orders in a chain, each followed by its physics alone.
class Bench {
 public:
  Bench(const ActorOptions& options, const actor::RolloutAssets& assets,
        const actor::PreparedSnapshot& snapshot, int thread)
      : options_(options),
        assets_(assets),
        snapshot_(snapshot),
        raw_(assets.task()) {
    order_.set_run_id("bench");
    order_.set_kind(v1::Order::KIND_TRAIN);
    order_.set_snapshot_version(snapshot.version());
    order_.set_snapshot_sha256(snapshot.sha256());
    order_.set_layout_sha256(assets.layout_sha256());
    order_.set_horizon(options.horizon);
    order_.set_first_environment(thread * options.environments);
    for (int e = 0; e < options.environments; ++e) order_.add_states();
  }

  absl::Status Run(const std::shared_ptr<const actor::RolloutAssets>& assets,
                   Rounds* rounds) {
    SINEW_ASSIGN_OR_RETURN(
        worker_, actor::RolloutWorker::Create(assets, options_.environments));
    SINEW_ASSIGN_OR_RETURN(products_,
                           ProductsAlone(assets_, options_.environments));
    Rounds warm_up;
    SINEW_RETURN_IF_ERROR(Round(&warm_up));
    for (int i = 0; i < options_.rounds; ++i) {
      SINEW_RETURN_IF_ERROR(Round(rounds));
    }
    return absl::OkStatus();
  }

 private:
  // The order's rollout again, in steps, for its physics.
  absl::Status PrepareRaw() {
    v1::Order step = order_;
    step.set_horizon(1);
    raw_.Clear();
    for (int i = 0; i < options_.horizon; ++i) {
      SINEW_ASSIGN_OR_RETURN(const v1::Segment segment,
                             worker_->Run(step, snapshot_));
      SINEW_RETURN_IF_ERROR(raw_.Add(step, segment));
      *step.mutable_states() = segment.end_states();
    }
    return absl::OkStatus();
  }

  // Seconds of the order's whole rollout, as training runs it.
  absl::StatusOr<double> TimeRollout() {
    const double begin = ThreadSeconds();
    SINEW_ASSIGN_OR_RETURN(segment_, worker_->Run(order_, snapshot_));
    bytes_.clear();
    segment_.AppendToString(&bytes_);
    return ThreadSeconds() - begin;
  }

  double TimeProducts() {
    const double begin = ThreadSeconds();
    for (int i = 0; i < options_.horizon; ++i) {
      products_->Run(options_.environments);
    }
    return ThreadSeconds() - begin;
  }

  absl::Status Round(Rounds* rounds) {
    SINEW_RETURN_IF_ERROR(PrepareRaw());
    double rollout = INFINITY, raw = INFINITY, products = INFINITY;
    int64_t raw_steps = 0;
    for (int i = 0; i < options_.repetitions; ++i) {
      SINEW_ASSIGN_OR_RETURN(const double seconds, TimeRollout());
      rollout = std::min(rollout, seconds);
      const double begin = ThreadSeconds();
      raw_steps = raw_.Run();
      raw = std::min(raw, ThreadSeconds() - begin);
      products = std::min(products, TimeProducts());
    }
    *order_.mutable_states() = segment_.end_states();
    order_.set_order_id(order_.order_id() + 1);
    if (raw_steps == 0) return absl::OkStatus();

    const double control_steps = options_.environments * options_.horizon;
    const auto steps = static_cast<double>(segment_.physics_steps());
    rounds->rollout_rate.push_back(steps / rollout);
    rounds->raw_rate.push_back(static_cast<double>(raw_steps) / raw);
    rounds->ratio.push_back(rounds->rollout_rate.back() /
                            rounds->raw_rate.back());
    rounds->step_us.push_back(1e6 * rollout / control_steps);
    rounds->other_us.push_back(rounds->step_us.back() -
                               1e6 * assets_.task().substeps() /
                                   rounds->raw_rate.back());
    rounds->products_us.push_back(1e6 * products / control_steps);
    return absl::OkStatus();
  }

  const ActorOptions& options_;
  const actor::RolloutAssets& assets_;
  const actor::PreparedSnapshot& snapshot_;
  RawPhysics raw_;
  std::unique_ptr<actor::RolloutWorker> worker_;
  std::unique_ptr<policy::Executor> products_;
  v1::Order order_;
  v1::Segment segment_;  // of the rollout timed last
  std::string bytes_;
};

absl::Status CheckTask(const world::TrackingTask& task) {
  const bool drives = task.recipe().task().actuator_model().drives_size() > 0;
  if (!drives && !task.randomisation().on()) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      "bench: expected a recipe without ",
      drives ? "task.actuator_model" : "task.randomisation",
      ", which the plain loop around mj_step does not know, found one with"));
}

}  // namespace

absl::StatusOr<ActorFigures> MeasureActor(
    const ActorOptions& options,
    const std::shared_ptr<const actor::RolloutAssets>& assets,
    const v1::Snapshot& snapshot) {
  if (options.threads < 1 || options.rounds < 1 || options.repetitions < 1) {
    return absl::InvalidArgumentError(absl::StrCat(
        "threads, rounds and repetitions: expected >= 1, found ",
        options.threads, ", ", options.rounds, " and ", options.repetitions));
  }
  SINEW_RETURN_IF_ERROR(CheckTask(assets->task()));
  SINEW_ASSIGN_OR_RETURN(
      const auto prepared,
      actor::PreparedSnapshot::Create(
          snapshot, Sha256Hex(SerializeDeterministically(snapshot)), *assets));
  std::vector<Rounds> rounds(options.threads);
  std::vector<absl::Status> statuses(options.threads);
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < options.threads; ++t) {
      threads.emplace_back([&, t] {
        statuses[t] =
            Bench(options, *assets, *prepared, t).Run(assets, &rounds[t]);
      });
    }
  }
  for (const absl::Status& status : statuses) SINEW_RETURN_IF_ERROR(status);
  Rounds all;
  for (const Rounds& one : rounds) all.Add(one);
  if (all.ratio.empty()) {
    return absl::InternalError("bench: no episode outlived an order");
  }
  return ActorFigures{.threads = options.threads,
                      .ratio = Median(all.ratio),
                      .rollout_steps_per_s = Median(all.rollout_rate),
                      .raw_steps_per_s = Median(all.raw_rate),
                      .step_us = Median(all.step_us),
                      .other_us = Median(all.other_us),
                      .products_us = Median(all.products_us)};
}

absl::StatusOr<v1::Snapshot> IdlePolicy(const actor::RolloutAssets& assets) {
  SINEW_ASSIGN_OR_RETURN(Policy policy, UntrainedPolicy(assets));
  // A composer's primitives are zero already.
  for (const char* name : {"policy/mean/weight", "decoder/action/weight"}) {
    const auto last = policy.weights.find(name);
    if (last == policy.weights.end()) continue;
    const auto elements = last->second.mutable_float32();
    std::fill(elements.begin(), elements.end(), 0.F);
  }
  v1::Snapshot snapshot;
  *snapshot.mutable_graph() = std::move(policy.graph);
  snapshot.set_weights(SerializeSafetensors(policy.weights));
  return snapshot;
}

}  // namespace sinew::bench
