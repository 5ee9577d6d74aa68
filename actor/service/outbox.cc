#include "actor/service/outbox.h"

#include <utility>

namespace sinew::actor {

bool Outbox::Push(OutgoingPtr segment) {
  const auto size = static_cast<int64_t>(segment->bytes.size());
  MutexLock lock(mu_);
  // Close ends the wait; the outbox outlives who pushes.
  while (!closed_ && !segments_.empty() && bytes_ + size > max_bytes_) {
    changed_.Wait(mu_, std::stop_token());
  }
  if (closed_) return false;
  segments_.push_back(std::move(segment));
  bytes_ += size;
  changed_.NotifyAll();
  return true;
}

bool Outbox::WaitForUnsent(const std::stop_token& stop) {
  MutexLock lock(mu_);
  while (sent_ == segments_.size()) {
    if (!changed_.Wait(mu_, stop)) return false;
  }
  return true;
}

OutgoingPtr Outbox::NextUnsent(const std::stop_token& stop) {
  MutexLock lock(mu_);
  while (sent_ == segments_.size()) {
    if (!changed_.Wait(mu_, stop)) return nullptr;
  }
  return segments_[sent_++];
}

OutgoingPtr Outbox::Acknowledge(int64_t order_id) {
  MutexLock lock(mu_);
  if (sent_ == 0 || segments_.front()->order_id != order_id) return nullptr;
  OutgoingPtr segment = std::move(segments_.front());
  segments_.pop_front();
  --sent_;
  bytes_ -= static_cast<int64_t>(segment->bytes.size());
  changed_.NotifyAll();
  return segment;
}

void Outbox::Rewind() {
  MutexLock lock(mu_);
  sent_ = 0;
  changed_.NotifyAll();
}

bool Outbox::WaitUntilEmpty(CondVar::TimePoint deadline) {
  MutexLock lock(mu_);
  while (!segments_.empty()) {
    if (!changed_.WaitUntil(mu_, deadline)) break;
  }
  return segments_.empty();
}

std::vector<int64_t> Outbox::Close() {
  MutexLock lock(mu_);
  closed_ = true;
  std::vector<int64_t> ids;
  for (const OutgoingPtr& segment : segments_) ids.push_back(segment->order_id);
  changed_.NotifyAll();
  return ids;
}

int64_t Outbox::bytes() const {
  MutexLock lock(mu_);
  return bytes_;
}

}  // namespace sinew::actor
