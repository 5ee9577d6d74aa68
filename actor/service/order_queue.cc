#include "actor/service/order_queue.h"

#include <stop_token>
#include <utility>

#include "absl/strings/str_cat.h"

namespace sinew::actor {

absl::Status OrderQueue::Push(v1::Order order) {
  MutexLock lock(mu_);
  if (closed_) {
    return absl::FailedPreconditionError("the actor is going away");
  }
  if (static_cast<int>(orders_.size()) >= capacity_) {
    return absl::ResourceExhaustedError(
        absl::StrCat("order ", order.order_id(), ": expected at most ",
                     capacity_, " orders to wait"));
  }
  orders_.push_back(std::move(order));
  changed_.NotifyOne();
  return absl::OkStatus();
}

std::optional<v1::Order> OrderQueue::Pop() {
  MutexLock lock(mu_);
  // Close ends the wait; the queue outlives its workers.
  while (orders_.empty() && !closed_) changed_.Wait(mu_, std::stop_token());
  if (orders_.empty()) return std::nullopt;
  v1::Order order = std::move(orders_.front());
  orders_.pop_front();
  return order;
}

std::vector<int64_t> OrderQueue::Clear() {
  MutexLock lock(mu_);
  std::vector<int64_t> ids;
  for (const v1::Order& order : orders_) ids.push_back(order.order_id());
  orders_.clear();
  return ids;
}

void OrderQueue::Close() {
  MutexLock lock(mu_);
  closed_ = true;
  changed_.NotifyAll();
}

bool OrderQueue::closed() const {
  MutexLock lock(mu_);
  return closed_;
}

}  // namespace sinew::actor
