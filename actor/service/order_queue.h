#ifndef SINEW_ACTOR_SERVICE_ORDER_QUEUE_H_
#define SINEW_ACTOR_SERVICE_ORDER_QUEUE_H_

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "common/mutex.h"
#include "proto/sinew/v1/rollout.pb.h"

namespace sinew::actor {

// Orders that wait for a worker thread: bounded, first in, first out.
//
// Thread-safety: any thread. Ownership: owns the orders. Blocking: Pop, until
// there is an order or the queue is closed. Errors: a full queue.
class OrderQueue {
 public:
  // `capacity` >= 1.
  explicit OrderQueue(int capacity) : capacity_(capacity) {}

  // RESOURCE_EXHAUSTED: full; FAILED_PRECONDITION: closed.
  absl::Status Push(v1::Order order) SINEW_EXCLUDES(mu_);

  // The next order; nullopt: closed, and nothing is left.
  std::optional<v1::Order> Pop() SINEW_EXCLUDES(mu_);

  // Removes what nobody has begun; returns the ids.
  std::vector<int64_t> Clear() SINEW_EXCLUDES(mu_);

  // No further orders; what is there can still be popped.
  void Close() SINEW_EXCLUDES(mu_);
  bool closed() const SINEW_EXCLUDES(mu_);

 private:
  const int capacity_;
  mutable Mutex mu_;
  CondVar changed_;
  std::deque<v1::Order> orders_ SINEW_GUARDED_BY(mu_);
  bool closed_ SINEW_GUARDED_BY(mu_) = false;
};

}  // namespace sinew::actor

#endif  // SINEW_ACTOR_SERVICE_ORDER_QUEUE_H_
