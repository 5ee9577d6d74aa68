#ifndef SINEW_LEARNER_TRAINER_ORDER_PLANNER_H_
#define SINEW_LEARNER_TRAINER_ORDER_PLANNER_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/rollout.pb.h"

namespace sinew::learner {

// Which snapshot orders act with.
struct SnapshotName {
  int64_t version = 0;
  std::string sha256;
};

// Writes orders: groups of consecutive environments for training, groups of
// starts for evaluation, ids rising. Keeps the environments between orders.
//
// Thread-safety: one caller. Ownership: owns the environment states. Blocking:
// never. Errors: Absorb refuses segments that do not fit their orders.
class OrderPlanner {
 public:
  struct Options {
    std::string run_id;
    std::string assets_sha256;
    std::string layout_sha256;
    uint64_t seed = 0;
    v1::Rollouts rollouts;  // defaults filled
    // Starts of every evaluation.
    std::vector<v1::EvaluationStart> evaluation_starts;
  };
  explicit OrderPlanner(Options options);

  // Orders of a training iteration from the current environment states.
  std::vector<v1::Order> PlanTraining(int64_t iteration,
                                      const SnapshotName& snapshot);
  // Orders of an evaluation begun at `iteration`.
  std::vector<v1::Order> PlanEvaluation(int64_t iteration,
                                        const SnapshotName& snapshot);

  // Takes the end states of training segments, `segments[i]` of `orders[i]`.
  // INTERNAL naming the order if sizes disagree; nothing is taken then.
  absl::Status Absorb(absl::Span<const v1::Order> orders,
                      absl::Span<const v1::Segment> segments);

  const std::vector<v1::EnvironmentState>& environments() const {
    return environments_;
  }
  int64_t next_order_id() const { return next_order_id_; }
  // From a training state; INVALID_ARGUMENT if the number of environments
  // differs.
  absl::Status Restore(absl::Span<const v1::EnvironmentState> environments,
                       int64_t next_order_id);

 private:
  v1::Order MakeOrder(v1::Order::Kind kind, int64_t iteration,
                      const SnapshotName& snapshot);

  const Options options_;
  std::vector<v1::EnvironmentState> environments_;
  int64_t next_order_id_ = 1;
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_TRAINER_ORDER_PLANNER_H_
