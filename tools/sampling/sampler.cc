#include "tools/sampling/sampler.h"

#include <algorithm>
#include <atomic>
#include <map>
#include <string>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/policy/validate.h"
#include "common/random/philox.h"
#include "common/status_macros.h"
#include "deploy/bundle/latent_graphs.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew::sampling {
namespace {

constexpr char kGraph[] = "sample";
constexpr char kLatent[] = "latent";
// Samples that a thread moves in step: fills a tile of the matrix kernels.
constexpr int kGroupSize = 8;

absl::Status Error(const bundle::Bundle& bundle, absl::string_view expected,
                   absl::string_view found) {
  return absl::InvalidArgumentError(
      absl::StrCat(bundle.directory, ": graph \"sample\": expected ", expected,
                   ", found ", found));
}

// What is said of latents is what the decoder takes: it is to be seen.
absl::StatusOr<int> FindLatentTap(const bundle::Bundle& bundle) {
  SINEW_ASSIGN_OR_RETURN(const v1::Graph* graph,
                         policy::FindGraph(bundle.graph, kGraph));
  SINEW_ASSIGN_OR_RETURN((const std::map<std::string, int64_t> widths),
                         policy::InferWidths(bundle.graph, kGraph));
  std::vector<std::string> taps;
  for (const v1::Tap& tap : graph->taps()) {
    if (tap.name() == kLatent &&
        widths.at(tap.value()) == bundle::LatentWidth(bundle.graph)) {
      return static_cast<int>(widths.at(tap.value()));
    }
    taps.push_back(tap.name());
  }
  return Error(bundle, "a tap \"latent\"", absl::StrJoin(taps, ", "));
}

absl::StatusOr<policy::Ports> FindSamplePorts(const bundle::Bundle& bundle) {
  absl::StatusOr<policy::Ports> ports = policy::FindPorts(bundle.graph, kGraph);
  if (absl::IsNotFound(ports.status())) {
    return absl::InvalidArgumentError(absl::StrCat(
        bundle.directory, ": expected a graph \"sample\", as bundles with a ",
        "latent have it, found ",
        absl::StrJoin(bundle.manifest.graphs(), ", ")));
  }
  SINEW_RETURN_IF_ERROR(ports.status());
  const auto joints = static_cast<int64_t>(bundle.character->joints().size());
  if (ports->action_width != joints) {
    return Error(bundle, absl::StrCat("an action of ", joints, " joints"),
                 absl::StrCat("width ", ports->action_width));
  }
  if (ports->noise.size() != 1) {
    return Error(bundle, "one noise input", absl::StrCat(ports->noise.size()));
  }
  return ports;
}

// The features of a transition's states: SELF_JOINT_SPACE.
absl::StatusOr<world::ObservationBuilder> StateFeatures(
    const character::Character& character) {
  v1::Observation recipe;
  recipe.add_blocks(v1::Observation::BLOCK_SELF_JOINT_SPACE);
  return world::ObservationBuilder::Create(
      recipe, static_cast<int>(character.tracked().size()),
      static_cast<int>(character.joints().size()),
      static_cast<int>(character.foot_bodies().size()));
}

}  // namespace

// Up to kGroupSize samples in step, on one thread.
class Sampler::Group {
 public:
  static absl::StatusOr<std::unique_ptr<Group>> Create(
      const Sampler& sampler, const SampleOrder& order) {
    auto group = std::unique_ptr<Group>(new Group(sampler, order));
    if (!order.noise) return group;
    // Row i with noise and row kGroupSize + i without: the latent and its mean.
    SINEW_ASSIGN_OR_RETURN(
        group->executor_,
        policy::Executor::Create(sampler.pack_, 2 * kGroupSize));
    policy::Executor& executor = *group->executor_;
    group->observation_ = executor.input_index(sampler.ports_.observation);
    group->noise_ = executor.input_index(sampler.ports_.noise.front());
    group->action_ = executor.tap_index(sampler.ports_.action);
    group->latent_ = executor.tap_index(kLatent);
    return group;
  }

  // Moves these from the first to the last step, or until `cancel`.
  void Run(absl::Span<SampleMotion> motions, const std::atomic<bool>& cancel) {
    skate_.clear();
    energy_.clear();
    for (size_t i = 0; i < motions.size(); ++i) {
      const SampleStart& start =
          order_.starts[static_cast<size_t>(motions[i].start)];
      bodies_[i]->Start(start.qpos, start.qvel);
      skate_.emplace_back(
          law().foot_of_sole(),
          static_cast<int>(law().character().foot_bodies().size()),
          law().control_hz());
      energy_.emplace_back(law().control_hz());
      Record(i, motions[i]);
    }
    for (int step = 0; step < order_.steps && !cancel; ++step) {
      if (executor_ != nullptr) Decide(motions, step);
      for (size_t i = 0; i < motions.size(); ++i) {
        if (!motions[i].diverged) Step(i, motions[i]);
      }
    }
    for (size_t i = 0; i < motions.size(); ++i) {
      motions[i].skate = skate_[i].figures();
      motions[i].energy = energy_[i].figures();
    }
  }

 private:
  Group(const Sampler& sampler, const SampleOrder& order)
      : sampler_(sampler),
        order_(order),
        zero_action_(static_cast<size_t>(sampler.law().num_joints())) {
    for (int i = 0; i < kGroupSize; ++i) {
      bodies_.push_back(std::make_unique<FreeBody>(sampler.law_));
    }
  }

  const BodyLaw& law() const { return *sampler_.law_; }

  // Row `row` of a [.., width] array.
  template <typename T>
  static absl::Span<T> Row(absl::Span<T> rows, int64_t width, size_t row) {
    return rows.subspan(row * static_cast<size_t>(width),
                        static_cast<size_t>(width));
  }

  void Decide(absl::Span<const SampleMotion> motions, int step) {
    policy::Executor& executor = *executor_;
    const int64_t width = executor.input_width(observation_);
    const absl::Span<float> inputs = executor.input(observation_);
    for (size_t i = 0; i < motions.size(); ++i) {
      if (motions[i].diverged) continue;
      const absl::Span<float> own = Row(inputs, width, i);
      bodies_[i]->Observe(own);
      std::copy(own.begin(), own.end(),
                Row(inputs, width, kGroupSize + i).begin());
      const absl::Span<float> noise =
          Row(executor.input(noise_), executor.input_width(noise_), i);
      FillNormal({.seed = order_.seed,
                  .environment = static_cast<uint64_t>(motions[i].sample),
                  .step = static_cast<uint64_t>(step),
                  .purpose = RandomPurpose::kAction},
                 noise);
      for (float& value : noise) {
        value *= static_cast<float>(*order_.noise);
      }
    }
    executor.Run(2 * kGroupSize);
  }

  void Step(size_t i, SampleMotion& motion) {
    absl::Span<const float> action = zero_action_;
    if (executor_ != nullptr) {
      action = Row(executor_->tap(action_), executor_->tap_width(action_), i);
    }
    if (!bodies_[i]->Step(action)) {
      motion.diverged = true;
      return;
    }
    if (executor_ != nullptr) {
      AppendLatent(i, motion.latent);
      AppendLatent(kGroupSize + i, motion.latent_mean);
    }
    Record(i, motion);
  }

  void AppendLatent(size_t row, std::vector<float>& to) const {
    const absl::Span<const float> latent =
        Row(executor_->tap(latent_), executor_->tap_width(latent_), row);
    to.insert(to.end(), latent.begin(), latent.end());
  }

  // The body's state as the motion's next frame.
  void Record(size_t i, SampleMotion& motion) {
    FreeBody& body = *bodies_[i];
    const world::BodyState& state = body.state();
    sampler_.AppendFeatures(state, motion.states);
    // The block ends with the bodies' positions relative to the root.
    const auto points = absl::MakeConstSpan(motion.states)
                            .last(3 * (state.position.size() - 1));
    motion.path.points.insert(motion.path.points.end(), points.begin(),
                              points.end());
    for (int axis = 0; axis < 2; ++axis) {
      motion.path.root.push_back(static_cast<float>(state.position[0][axis]));
    }
    motion.upright_height.push_back(body.UprightHeight());
    skate_[i].Add(body.SolePoints());
    energy_[i].Add(state.position, state.joint_velocity);
    if (motion.sample < order_.keep_qpos) {
      const absl::Span<const double> qpos = body.qpos();
      motion.qpos.insert(motion.qpos.end(), qpos.begin(), qpos.end());
    }
  }

  const Sampler& sampler_;
  const SampleOrder& order_;
  const std::vector<float> zero_action_;
  std::unique_ptr<policy::Executor> executor_;  // null: the zero action
  int observation_ = -1, noise_ = -1, action_ = -1, latent_ = -1;
  std::vector<std::unique_ptr<FreeBody>> bodies_;
  std::vector<metrics::FootSkateMeter> skate_;
  std::vector<metrics::MotionEnergyMeter> energy_;
};

absl::StatusOr<std::unique_ptr<const Sampler>> Sampler::Create(
    const bundle::Bundle& bundle) {
  SINEW_ASSIGN_OR_RETURN(policy::Ports ports, FindSamplePorts(bundle));
  SINEW_ASSIGN_OR_RETURN(const int latent_width, FindLatentTap(bundle));
  SINEW_ASSIGN_OR_RETURN(std::shared_ptr<const BodyLaw> law,
                         BodyLaw::Create(bundle, ports.observation_width));
  SINEW_ASSIGN_OR_RETURN(
      std::shared_ptr<const policy::WeightsPack> pack,
      policy::PackWeights(bundle.graph, kGraph, bundle.weights));
  SINEW_ASSIGN_OR_RETURN(world::ObservationBuilder features,
                         StateFeatures(*bundle.character));
  return std::unique_ptr<const Sampler>(
      new Sampler(std::move(law), std::move(ports), std::move(pack),
                  latent_width, std::move(features)));
}

Sampler::Sampler(std::shared_ptr<const BodyLaw> law, policy::Ports ports,
                 std::shared_ptr<const policy::WeightsPack> pack,
                 int latent_width, world::ObservationBuilder features)
    : law_(std::move(law)),
      ports_(std::move(ports)),
      pack_(std::move(pack)),
      latent_width_(latent_width),
      features_(std::move(features)) {}

void Sampler::AppendFeatures(const world::BodyState& state,
                             std::vector<float>& rows) const {
  const auto width = static_cast<size_t>(num_features());
  rows.resize(rows.size() + width);
  features_.Build({.body = &state,
                   .reference = {},
                   .reference_contact = {},
                   .previous_target = {},
                   .self_contact = {}},
                  absl::MakeSpan(rows).last(width));
}

absl::StatusOr<std::vector<SampleMotion>> Sampler::Run(
    const SampleOrder& order, const StopToken& stop) const {
  std::vector<SampleMotion> motions(order.starts.size() *
                                    static_cast<size_t>(order.per_start));
  for (size_t i = 0; i < motions.size(); ++i) {
    motions[i].sample = static_cast<int64_t>(i);
    motions[i].start = static_cast<int>(i) / order.per_start;
  }
  constexpr auto kSize = static_cast<size_t>(kGroupSize);
  const size_t groups = (motions.size() + kSize - 1) / kSize;
  std::vector<std::unique_ptr<Group>> workers;
  while (workers.size() <
         std::min(groups, static_cast<size_t>(order.threads))) {
    SINEW_ASSIGN_OR_RETURN(std::unique_ptr<Group> worker,
                           Group::Create(*this, order));
    workers.push_back(std::move(worker));
  }
  std::atomic<size_t> next = 0;
  std::atomic<bool> cancel = false;
  {
    const std::stop_callback cancelled(stop, [&cancel] { cancel = true; });
    std::vector<std::jthread> joined;
    for (const std::unique_ptr<Group>& worker : workers) {
      joined.emplace_back([&, group = worker.get()] {
        for (size_t g = next++; g < groups && !cancel; g = next++) {
          // Every group writes motions of its own.
          group->Run(absl::MakeSpan(motions).subspan(g * kSize, kSize), cancel);
        }
      });
    }
  }
  if (stop.stop_requested()) {
    return absl::CancelledError("sampling: stopped before its end");
  }
  return motions;
}

}  // namespace sinew::sampling
