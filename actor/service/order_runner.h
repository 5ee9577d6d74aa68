#ifndef SINEW_ACTOR_SERVICE_ORDER_RUNNER_H_
#define SINEW_ACTOR_SERVICE_ORDER_RUNNER_H_

#include <atomic>
#include <memory>

#include "absl/status/statusor.h"
#include "actor/service/actor_metrics.h"
#include "actor/service/applied_versions.h"
#include "actor/service/engine.h"
#include "actor/service/order_inputs.h"
#include "proto/sinew/v1/rollout.pb.h"

namespace sinew::actor {

// One thread's way from an order to its segment: inputs by digest, a worker
// that fits, the rollout. Keeps the worker for the next order.
//
// Thread-safety: one thread. Ownership: borrows all; shares assets. Blocking:
// while inputs are fetched, and for the rollout, which looks at `cancel` every
// control step. Errors: of inputs and engine; CANCELLED.
class OrderRunner {
 public:
  struct Result {
    v1::Segment segment;
    // See AppliedVersions.
    double apply_seconds = 0;
  };

  OrderRunner(Engine& engine, OrderInputs& inputs, AppliedVersions& versions,
              ActorMetrics& metrics, const std::atomic<bool>& cancel)
      : engine_(engine),
        inputs_(inputs),
        versions_(versions),
        metrics_(metrics),
        cancel_(cancel) {}

  absl::StatusOr<Result> Run(const v1::Order& order);

 private:
  Engine& engine_;
  OrderInputs& inputs_;
  AppliedVersions& versions_;
  ActorMetrics& metrics_;
  const std::atomic<bool>& cancel_;
  Engine::AssetsPtr assets_;
  int max_environments_ = 0;
  std::unique_ptr<Engine::Worker> worker_;
};

}  // namespace sinew::actor

#endif  // SINEW_ACTOR_SERVICE_ORDER_RUNNER_H_
