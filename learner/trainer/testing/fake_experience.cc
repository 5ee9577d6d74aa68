#include "learner/trainer/testing/fake_experience.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/check.h"
#include "common/policy/safetensors.h"
#include "common/status_macros.h"

namespace sinew::learner {
namespace {

constexpr size_t kKeptSnapshots = 3;

absl::string_view KindName(const v1::Order& order) {
  return order.kind() == v1::Order::KIND_TRAIN ? "train" : "evaluate";
}

void AddEpisodes(const v1::Order& order, int steps, bool carried,
                 v1::Segment& segment) {
  for (int e = 0; e < order.states_size(); ++e) {
    v1::EpisodeEnd& episode = *segment.add_episodes();
    episode.set_environment(order.first_environment() + e);
    episode.set_episode(order.iteration());
    // Terminated, time limit, clip end, diverged.
    episode.set_reason(static_cast<v1::EpisodeEnd::Reason>(1 + e % 4));
    episode.set_start_frame(e % 2);
    if (carried && e % 2 == 1) {
      episode.set_start_kind(v1::START_KIND_CARRIED);
    }
    episode.set_steps(steps);
    segment.set_diverged(segment.diverged() + (e % 4 == 3));
  }
}

}  // namespace

absl::Status FakeExperience::Publish(const PublishedSnapshot& snapshot) {
  log_.push_back(absl::StrCat("publish ", snapshot.snapshot.version()));
  published_.push_back(snapshot);
  return absl::OkStatus();
}

absl::Status FakeExperience::Begin(const std::vector<v1::Order>& orders) {
  SINEW_CHECK(!orders.empty());
  for (const v1::Order& order : orders) {
    orders_.push_back(order);
    open_[order.order_id()] = order;
  }
  log_.push_back(absl::StrCat("begin ", KindName(orders[0]), " ",
                              orders[0].iteration(), " with ",
                              orders[0].snapshot_version()));
  return absl::OkStatus();
}

absl::StatusOr<std::vector<v1::Segment>> FakeExperience::Take(
    const std::vector<int64_t>& order_ids) {
  if (!next_take.ok()) return std::exchange(next_take, absl::OkStatus());
  std::vector<v1::Segment> segments;
  for (int64_t id : order_ids) {
    const auto found = open_.find(id);
    if (found == open_.end()) {
      return absl::NotFoundError(absl::StrCat("order ", id, " is not open"));
    }
    const v1::Order& order = found->second;
    const auto oldest =
        published_.end() - std::min(kKeptSnapshots, published_.size());
    const auto snapshot =
        std::find_if(oldest, published_.end(), [&](const auto& kept) {
          return kept.sha256 == order.snapshot_sha256();
        });
    if (snapshot == published_.end()) {
      return absl::FailedPreconditionError(absl::StrCat(
          "order ", id, ": no snapshot ", order.snapshot_version()));
    }
    segments.push_back(order.kind() == v1::Order::KIND_TRAIN
                           ? Train(order, *snapshot)
                           : Evaluate(order));
    const std::string line =
        absl::StrCat("take ", KindName(order), " ", order.iteration());
    if (log_.back() != line) log_.push_back(line);
  }
  for (int64_t id : order_ids) open_.erase(id);
  return segments;
}

v1::Segment FakeExperience::Train(const v1::Order& order,
                                  const PublishedSnapshot& snapshot) {
  auto weights = ParseSafetensors(snapshot.snapshot.weights(), "snapshot");
  SINEW_CHECK(weights.ok()) << weights.status().ToString();
  // A problem per order: the end states enter its seed.
  SyntheticProblem problem = problem_;
  problem.orders = 1;
  problem.environments = order.states_size();
  problem.steps = order.horizon();
  problem.seed = problem_.seed + order.first_environment();
  const int64_t done = order.states(0).step();
  v1::Segment segment = std::move(MakeSyntheticSegments(
      problem, snapshot.snapshot.graph(), *weights, done)[0]);
  segment.set_run_id(order.run_id());
  segment.set_order_id(order.order_id());
  segment.set_iteration(order.iteration());
  segment.set_snapshot_version(order.snapshot_version());
  for (const v1::EnvironmentState& state : order.states()) {
    v1::EnvironmentState& end = *segment.add_end_states();
    end.set_step(state.step() + order.horizon());
    end.add_physics(0.5 * order.order_id());
  }
  AddEpisodes(order, order.horizon(), carried, segment);
  segment.set_physics_steps(int64_t{4} * order.horizon() * order.states_size());
  segment.mutable_seconds()->set_simulate(0.25);
  return segment;
}

v1::Segment FakeExperience::Evaluate(const v1::Order& order) const {
  v1::Segment segment;
  segment.set_order_id(order.order_id());
  segment.set_kind(v1::Order::KIND_EVALUATE);
  segment.set_iteration(order.iteration());
  for (const v1::EvaluationStart& start : order.starts()) {
    v1::EvaluationResult& result = *segment.add_results();
    result.set_clip(start.clip());
    result.set_start_frame(start.start_frame());
    result.set_steps(start.steps());
    result.set_success(order.snapshot_version() >= success_version);
    result.set_frames(result.success() ? start.steps() : start.steps() / 2);
    result.set_failed_at_frame(result.success() ? -1 : result.frames());
  }
  segment.mutable_seconds()->set_infer(0.5);
  return segment;
}

}  // namespace sinew::learner
