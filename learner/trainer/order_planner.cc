#include "learner/trainer/order_planner.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"

namespace sinew::learner {

OrderPlanner::OrderPlanner(Options options)
    : options_(std::move(options)),
      environments_(options_.rollouts.environments()) {}

v1::Order OrderPlanner::MakeOrder(v1::Order::Kind kind, int64_t iteration,
                                  const SnapshotName& snapshot) {
  v1::Order order;
  order.set_run_id(options_.run_id);
  order.set_order_id(next_order_id_++);
  order.set_kind(kind);
  order.set_iteration(iteration);
  order.set_snapshot_version(snapshot.version);
  order.set_snapshot_sha256(snapshot.sha256);
  order.set_assets_sha256(options_.assets_sha256);
  order.set_layout_sha256(options_.layout_sha256);
  order.set_seed(options_.seed);
  return order;
}

std::vector<v1::Order> OrderPlanner::PlanTraining(
    int64_t iteration, const SnapshotName& snapshot) {
  const int group = options_.rollouts.environments_per_order();
  std::vector<v1::Order> orders;
  for (size_t first = 0; first < environments_.size(); first += group) {
    v1::Order& order = orders.emplace_back(
        MakeOrder(v1::Order::KIND_TRAIN, iteration, snapshot));
    order.set_horizon(options_.rollouts.horizon());
    order.set_first_environment(static_cast<int32_t>(first));
    for (int i = 0; i < group; ++i) {
      *order.add_states() = environments_[first + i];
    }
  }
  return orders;
}

std::vector<v1::Order> OrderPlanner::PlanEvaluation(
    int64_t iteration, const SnapshotName& snapshot) {
  const size_t group = options_.rollouts.environments_per_order();
  const auto& starts = options_.evaluation_starts;
  std::vector<v1::Order> orders;
  for (size_t first = 0; first < starts.size(); first += group) {
    v1::Order& order = orders.emplace_back(
        MakeOrder(v1::Order::KIND_EVALUATE, iteration, snapshot));
    order.set_first_environment(static_cast<int32_t>(first));
    int32_t longest = 1;
    for (size_t i = first; i < std::min(first + group, starts.size()); ++i) {
      *order.add_starts() = starts[i];
      longest = std::max(longest, starts[i].steps());
    }
    order.set_horizon(longest);
  }
  return orders;
}

absl::Status OrderPlanner::Absorb(absl::Span<const v1::Order> orders,
                                  absl::Span<const v1::Segment> segments) {
  if (orders.size() != segments.size()) {
    return absl::InternalError(absl::StrCat(
        "expected ", orders.size(), " segments, found ", segments.size()));
  }
  for (size_t i = 0; i < orders.size(); ++i) {
    if (segments[i].order_id() != orders[i].order_id() ||
        segments[i].end_states_size() != orders[i].states_size()) {
      return absl::InternalError(absl::StrCat(
          "order ", orders[i].order_id(), ": expected ",
          orders[i].states_size(), " end states, found ",
          segments[i].end_states_size(), " of order ", segments[i].order_id()));
    }
  }
  for (size_t i = 0; i < orders.size(); ++i) {
    std::copy(segments[i].end_states().begin(), segments[i].end_states().end(),
              environments_.begin() + orders[i].first_environment());
  }
  return absl::OkStatus();
}

absl::Status OrderPlanner::Restore(
    absl::Span<const v1::EnvironmentState> environments,
    int64_t next_order_id) {
  if (environments.size() != environments_.size()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "training state: expected ", environments_.size(),
        " environments (rollouts.environments), found ", environments.size()));
  }
  environments_.assign(environments.begin(), environments.end());
  next_order_id_ = next_order_id;
  return absl::OkStatus();
}

}  // namespace sinew::learner
