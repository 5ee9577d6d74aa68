#include "learner/dispatcher/roster.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/logging.h"

namespace sinew::learner {
namespace {

// Heartbeats an actor may miss before its leases end.
constexpr double kMissedHeartbeats = 3;
// Orders one actor may ask for; a bound against nonsense, far above need.
constexpr int64_t kMaxWant = 1024;
// Equal orders give equal segments: after that many refusals of one order, a
// fault of an actor's machine is no explanation any more.
constexpr int kMaxRefused = 3;

absl::Status GoingAway() {
  return absl::UnavailableError("the learner is going away");
}

// Above all issues of a learner that came before, which hands over less than a
// million orders per second.
int64_t FirstIssue(const Clock& clock) {
  return absl::ToUnixMicros(clock.WallNow());
}

// A peer's number of seconds that is to be summed.
double Reported(double seconds) {
  return std::isfinite(seconds) ? std::max(0.0, seconds) : 0;
}

}  // namespace

Roster::Roster(const Dispatcher::Options& options, const Clock& clock)
    : welcome_(options.welcome),
      admission_{options.build, options.mujoco_version, options.cpu_class},
      longest_silence_(kMissedHeartbeats *
                       absl::Seconds(options.welcome.heartbeat_seconds())),
      clock_(clock),
      pool_(options.reissue_after, FirstIssue(clock)) {}

void Roster::Enter(Session& session) {
  session.last_heard = clock_.SteadyNow();
  sessions_[session.id] = &session;
  if (draining_) DrainOne(session);
}

void Roster::Leave(Session& session) {
  Forget(session);
  sessions_.erase(session.id);
}

void Roster::Handle(Session& session, const v1::ActorMessage& message) {
  session.last_heard = clock_.SteadyNow();
  if (session.closing()) return;
  if (!session.registered) {
    Admit(session, message);
    return;
  }
  switch (message.message_case()) {
    case v1::ActorMessage::kWant: {
      const int64_t count = message.want().count();
      if (count < 1) {
        Close(session, absl::InvalidArgumentError(absl::StrCat(
                           "want.count: expected >= 1, found ", count)));
        return;
      }
      session.want = std::min(kMaxWant, session.want + count);
      return;
    }
    case v1::ActorMessage::kHeartbeat:
      return;
    case v1::ActorMessage::kDone:
      Finish(session, message.done());
      return;
    case v1::ActorMessage::kReturn:
      TakeBack(session, message.return_());
      return;
    default:
      Close(session, absl::InvalidArgumentError(
                         "expected want, heartbeat, done or return after "
                         "register"));
  }
}

void Roster::Admit(Session& session, const v1::ActorMessage& message) {
  const absl::Status admitted =
      message.has_register_()
          ? CheckAdmission(admission_, message.register_())
          : absl::FailedPreconditionError("expected register as first message");
  if (!admitted.ok()) {
    ++totals_.refused_actors;
    Close(session, admitted);
    return;
  }
  session.registered = true;
  session.threads = message.register_().threads();
  v1::DispatcherMessage welcome;
  *welcome.mutable_welcome() = welcome_;
  session.Push(std::move(welcome));
}

void Roster::Finish(Session& session, const v1::ActorMessage::Done& done) {
  pool_.Finish(session.id, done.order_id(), done.issue());
  totals_.idle_seconds += Reported(done.idle_seconds());
  totals_.blocked_seconds += Reported(done.blocked_seconds());
  if (done.applied_version() <= session.applied_version) return;
  session.applied_version = done.applied_version();
  totals_.applied_version =
      std::max(totals_.applied_version, done.applied_version());
  totals_.apply_seconds = Reported(done.apply_seconds());
}

void Roster::TakeBack(Session& session,
                      const v1::ActorMessage::Return& returned) {
  for (int64_t id : returned.order_ids()) {
    if (!returned.refused()) {
      if (pool_.Return(session.id, id)) ++totals_.orders_returned;
      continue;
    }
    const int times = pool_.Refuse(session.id, id);
    if (times == 0) continue;
    ++totals_.orders_returned;
    LogWarning(
        "replay refused the segment of an order",
        {{"order", id}, {"times", times}, {"reason", returned.reason()}});
    if (times < kMaxRefused) continue;
    failure_.Update(absl::FailedPreconditionError(
        absl::StrCat("order ", id, ": replay refused its segment ", times,
                     " times, the last time with ", returned.reason())));
  }
}

void Roster::Close(Session& session, const absl::Status& status) {
  session.Close(status);
  Forget(session);
}

void Roster::Forget(Session& session) {
  if (pool_.held_by(session.id) > 0) ++totals_.lost_actors;
  pool_.Forget(session.id);
}

void Roster::CloseSilent() {
  const TimePoint now = clock_.SteadyNow();
  for (auto& [id, session] : sessions_) {
    if (absl::FromChrono(now - session->last_heard) <= longest_silence_) {
      continue;
    }
    // Told why a while ago and still there: it does not even read, and only
    // cancelling ends a write that stands still.
    if (session->closing()) session->Cancel();
    Close(*session,
          absl::UnavailableError(absl::StrCat(
              "no heartbeat for ", absl::FormatDuration(longest_silence_))));
  }
}

void Roster::Drain() {
  draining_ = true;
  for (auto& [id, session] : sessions_) DrainOne(*session);
}

void Roster::Interrupt() {
  draining_ = true;
  for (auto& [id, session] : sessions_) Close(*session, GoingAway());
}

void Roster::DrainOne(Session& session) {
  if (!session.registered) {
    Close(session, GoingAway());
    return;
  }
  session.want = 0;
  for (int64_t id : session.DropQueuedOrders()) pool_.Return(session.id, id);
  v1::DispatcherMessage message;
  message.mutable_drain()->set_reason("the learner has no more orders");
  session.Push(std::move(message));
}

void Roster::CancelAll() {
  for (auto& [id, session] : sessions_) session->Cancel();
}

void Roster::Advance(SessionActions& actions) {
  if (!draining_) Match();
  for (auto& [id, session] : sessions_) {
    if (draining_ && session->registered && pool_.held_by(id) == 0) {
      session->Close(absl::OkStatus());
    }
    session->Collect(actions);
  }
}

// Fairly: one order each in turn.
void Roster::Match() {
  // For the pool, whose times are only compared with each other.
  const absl::Time now =
      absl::UnixEpoch() +
      absl::FromChrono(clock_.SteadyNow().time_since_epoch());
  bool progress = true;
  while (progress) {
    progress = false;
    for (auto& [id, session] : sessions_) {
      if (session->want == 0) continue;
      std::optional<v1::Order> order = pool_.Assign(id, now);
      if (!order) continue;
      v1::DispatcherMessage message;
      *message.mutable_order() = *std::move(order);
      session->Push(std::move(message));
      --session->want;
      progress = true;
    }
  }
}

Dispatcher::Statistics Roster::statistics() const {
  Dispatcher::Statistics result = totals_;
  for (const auto& [id, session] : sessions_) {
    if (!session->registered || session->closing()) continue;
    ++result.actors;
    result.threads += session->threads;
  }
  result.orders_waiting = pool_.waiting();
  result.orders_leased = pool_.leased();
  result.orders_reissued = pool_.reissued();
  return result;
}

}  // namespace sinew::learner
