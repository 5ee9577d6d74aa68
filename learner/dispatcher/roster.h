#ifndef SINEW_LEARNER_DISPATCHER_ROSTER_H_
#define SINEW_LEARNER_DISPATCHER_ROSTER_H_

#include <cstdint>
#include <map>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "common/clock.h"
#include "learner/dispatcher/admission.h"
#include "learner/dispatcher/dispatcher.h"
#include "learner/dispatcher/order_pool.h"
#include "learner/dispatcher/session.h"
#include "proto/sinew/v1/dispatch.pb.h"

namespace sinew::learner {

// The dispatcher without its lock and thread: which actors are there, what
// each has asked for, and what follows from a message, from silence, from new
// orders and from the end. Whoever changes something calls Advance, then runs
// the actions outside the lock.
//
// Thread-safety: none; the dispatcher guards it. Ownership: borrows sessions
// between Enter and Leave, and the clock. Blocking: never. Errors: become the
// status that a session ends with.
class Roster {
 public:
  using TimePoint = Clock::TimePoint;

  Roster(const Dispatcher::Options& options, const Clock& clock);

  // A stream begins, or has ended.
  void Enter(Session& session);
  void Leave(Session& session);
  bool empty() const { return sessions_.empty(); }

  // What an actor says. Register is the first message.
  void Handle(Session& session, const v1::ActorMessage& message);
  // The stream ends; what its actor held waits again.
  void Close(Session& session, const absl::Status& status);
  // Ends the streams of actors silent for three heartbeats.
  void CloseSilent();

  void AddOrders(const std::vector<v1::Order>& orders) { pool_.Add(orders); }
  void RetireOrders(const std::vector<int64_t>& ids) { pool_.Retire(ids); }

  std::vector<int64_t> finished_orders() const { return pool_.finished(); }

  // From now on nobody is admitted and no order is given out; a stream ends
  // once its actor holds nothing.
  void Drain();
  bool draining() const { return draining_; }
  // The same, but that all streams end now, whatever their actors hold.
  void Interrupt();
  // Breaks all streams off.
  void CancelAll();

  // Gives out orders, ends what is drained, collects what may be started.
  void Advance(SessionActions& actions);

  Dispatcher::Statistics statistics() const;
  const absl::Status& failure() const { return failure_; }

 private:
  void Admit(Session& session, const v1::ActorMessage& message);
  void Finish(Session& session, const v1::ActorMessage::Done& done);
  void TakeBack(Session& session, const v1::ActorMessage::Return& returned);
  void DrainOne(Session& session);
  void Forget(Session& session);
  void Match();

  const v1::DispatcherMessage::Welcome welcome_;
  const Admission admission_;
  const absl::Duration longest_silence_;
  const Clock& clock_;
  OrderPool pool_;
  std::map<int64_t, Session*> sessions_;
  bool draining_ = false;
  Dispatcher::Statistics totals_;
  absl::Status failure_;
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_DISPATCHER_ROSTER_H_
