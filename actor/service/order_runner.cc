#include "actor/service/order_runner.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "common/status_macros.h"

namespace sinew::actor {

absl::StatusOr<OrderRunner::Result> OrderRunner::Run(const v1::Order& order) {
  SINEW_ASSIGN_OR_RETURN(OrderInputs::Inputs inputs, inputs_.Get(order));
  const int environments =
      std::max({1, order.states_size(), order.starts_size()});
  if (inputs.assets != assets_ || environments > max_environments_) {
    worker_ = nullptr;
    SINEW_ASSIGN_OR_RETURN(worker_,
                           engine_.MakeWorker(inputs.assets, environments));
    assets_ = inputs.assets;
    max_environments_ = environments;
  }
  Result result;
  result.apply_seconds = versions_.Apply(order.snapshot_version(),
                                         std::chrono::steady_clock::now());
  SINEW_ASSIGN_OR_RETURN(result.segment,
                         worker_->Run(order, *inputs.snapshot, cancel_));
  metrics_.Count(order, result.segment);
  return result;
}

}  // namespace sinew::actor
