#ifndef SINEW_ACTOR_SERVICE_OUTBOX_H_
#define SINEW_ACTOR_SERVICE_OUTBOX_H_

#include <cstdint>
#include <deque>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "common/mutex.h"

namespace sinew::actor {

// A serialised segment on its way to replay, with what Done reports about it.
struct OutgoingSegment {
  std::string run_id;
  int64_t order_id = 0;
  int64_t issue = 0;  // of the order
  std::string bytes;
  int64_t applied_version = 0;
  double apply_seconds = 0;
  double idle_seconds = 0;
  double blocked_seconds = 0;
};
using OutgoingPtr = std::shared_ptr<const OutgoingSegment>;

// Segments from their rollout to replay's verdict: first in, first out,
// bounded in bytes, kept until they are answered so that a broken stream loses
// nothing.
//
//   workers: Push ...        sender: NextUnsent -> write, NextUnsent -> write
//                            reader: verdict -> Acknowledge(order)
//                            broken: Rewind, connect again
//
// Thread-safety: any thread. Ownership: shares the segments. Blocking: Push
// while full (this is how replay's back-pressure reaches the workers),
// NextUnsent, WaitUntilEmpty. Errors: none.
class Outbox {
 public:
  // `max_bytes` >= 1; a single larger segment passes when nothing else waits.
  explicit Outbox(int64_t max_bytes) : max_bytes_(max_bytes) {}

  // False: closed; the segment is not kept.
  bool Push(OutgoingPtr segment) SINEW_EXCLUDES(mu_);

  // The oldest segment that was not handed out since Rewind; null: stopped.
  OutgoingPtr NextUnsent(const std::stop_token& stop) SINEW_EXCLUDES(mu_);
  // Waits for one without handing it out; false: stopped.
  bool WaitForUnsent(const std::stop_token& stop) SINEW_EXCLUDES(mu_);

  // Removes the oldest segment, whose verdict has come; null if that is not
  // the one of `order_id` or was not sent.
  OutgoingPtr Acknowledge(int64_t order_id) SINEW_EXCLUDES(mu_);

  // Everything without verdict is to be sent again.
  void Rewind() SINEW_EXCLUDES(mu_);

  // True once nothing waits; false at `deadline`.
  bool WaitUntilEmpty(CondVar::TimePoint deadline) SINEW_EXCLUDES(mu_);

  // Refuses further segments and wakes who pushes; returns the orders of those
  // that are still here.
  std::vector<int64_t> Close() SINEW_EXCLUDES(mu_);

  int64_t bytes() const SINEW_EXCLUDES(mu_);

 private:
  const int64_t max_bytes_;
  mutable Mutex mu_;
  CondVar changed_;
  std::deque<OutgoingPtr> segments_ SINEW_GUARDED_BY(mu_);
  // How many of them were sent.
  size_t sent_ SINEW_GUARDED_BY(mu_) = 0;
  int64_t bytes_ SINEW_GUARDED_BY(mu_) = 0;
  bool closed_ SINEW_GUARDED_BY(mu_) = false;
};

}  // namespace sinew::actor

#endif  // SINEW_ACTOR_SERVICE_OUTBOX_H_
