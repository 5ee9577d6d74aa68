#include "learner/dispatcher/session.h"

#include <utility>

#include "common/rpc/status.h"

namespace sinew::learner {

void SessionActions::Run() {
  for (Session* session : write) session->StartWrite(&session->outgoing_);
  for (Session* session : finish) session->Finish(session->final_status_);
}

void Session::Push(v1::DispatcherMessage message) {
  if (!closing_) queue_.push_back(std::move(message));
}

std::vector<int64_t> Session::DropQueuedOrders() {
  std::vector<int64_t> ids;
  std::deque<v1::DispatcherMessage> kept;
  for (v1::DispatcherMessage& message : queue_) {
    if (message.has_order()) {
      ids.push_back(message.order().order_id());
    } else {
      kept.push_back(std::move(message));
    }
  }
  queue_ = std::move(kept);
  return ids;
}

void Session::Close(const absl::Status& status) {
  if (closing_) return;
  closing_ = true;
  want = 0;
  final_status_ = rpc::ToGrpc(status);
}

void Session::Collect(SessionActions& actions) {
  if (writing_ || finishing_) return;
  if (!queue_.empty()) {
    outgoing_ = std::move(queue_.front());
    queue_.pop_front();
    writing_ = true;
    actions.write.push_back(this);
  } else if (closing_ && reads_being_started_ == 0) {
    finishing_ = true;
    actions.finish.push_back(this);
  }
}

}  // namespace sinew::learner
