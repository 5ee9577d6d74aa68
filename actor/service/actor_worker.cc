// The worker threads of an actor, and what they and the sender report.
#include <chrono>
#include <optional>
#include <string>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "actor/service/actor.h"
#include "common/logging.h"
#include "common/status_macros.h"

namespace sinew::actor {
namespace {

using SteadyClock = std::chrono::steady_clock;

double SecondsSince(SteadyClock::time_point start) {
  return std::chrono::duration<double>(SteadyClock::now() - start).count();
}

// No actor of this build will ever run such an order.
bool IsHopeless(const absl::Status& status) {
  return absl::IsInvalidArgument(status) || absl::IsFailedPrecondition(status);
}

// The segment itself is wrong, as opposed to late or of no use any more.
bool IsRefusedForGood(v1::PutSegmentResponse::Verdict verdict) {
  return verdict != v1::PutSegmentResponse::VERDICT_ACCEPTED &&
         verdict != v1::PutSegmentResponse::VERDICT_DUPLICATE &&
         verdict != v1::PutSegmentResponse::VERDICT_UNEXPECTED;
}

}  // namespace

void Actor::Work() {
  OrderRunner runner(engine_, inputs_, versions_, metrics_, cancel_);
  rpc::Backoff backoff(options_.backoff, rpc::FreshSeed());
  Spent spent;
  while (true) {
    const auto idle_since = SteadyClock::now();
    const std::optional<v1::Order> order = queue_.Pop();
    spent.idle = SecondsSince(idle_since);
    metrics_.stage_seconds.Add("idle", spent.idle);
    if (!order.has_value()) break;
    const absl::Status status = RunOrder(*order, runner, spent);
    if (status.ok()) {
      backoff.Reset();
    } else {
      ReportFailure(*order, status);
      rpc::WaitFor(backoff.Next(), abandon_.get_token());
    }
    const std::shared_ptr<Connection> connection = AddHeld(-1);
    if (connection != nullptr && !queue_.closed()) connection->SendWant(1);
  }
  MutexLock lock(mu_);
  --working_;
  changed_.NotifyAll();
}

absl::Status Actor::RunOrder(const v1::Order& order, OrderRunner& runner,
                             Spent& spent) {
  SINEW_ASSIGN_OR_RETURN(OrderRunner::Result result, runner.Run(order));
  const OutgoingPtr outgoing = MakeOutgoing(order, std::move(result), spent);
  const auto push_since = SteadyClock::now();
  const bool pushed = outbox_.Push(outgoing);
  spent.blocked = SecondsSince(push_since);
  metrics_.stage_seconds.Add("blocked", spent.blocked);
  metrics_.queue_bytes.Set(static_cast<double>(outbox_.bytes()));
  return pushed ? absl::OkStatus()
                : absl::CancelledError("the actor goes away");
}

OutgoingPtr Actor::MakeOutgoing(const v1::Order& order,
                                OrderRunner::Result result, Spent& spent) {
  const auto start = SteadyClock::now();
  // A segment cannot tell how long it took to write itself: the one before it
  // stands in.
  result.segment.mutable_seconds()->set_encode(spent.encode);
  auto outgoing = std::make_shared<OutgoingSegment>();
  outgoing->run_id = order.run_id();
  outgoing->order_id = order.order_id();
  outgoing->issue = order.issue();
  outgoing->bytes = result.segment.SerializeAsString();
  outgoing->applied_version = order.snapshot_version();
  outgoing->apply_seconds = result.apply_seconds;
  outgoing->idle_seconds = spent.idle;
  outgoing->blocked_seconds = spent.blocked;
  spent.encode = SecondsSince(start);
  metrics_.stage_seconds.Add("encode", spent.encode);
  return outgoing;
}

void Actor::ReportFailure(const v1::Order& order, const absl::Status& status) {
  const std::string name = absl::StrCat("order ", order.order_id());
  std::string text(status.message());
  // The order's own checks name it already.
  if (!absl::StartsWith(text, name)) text = absl::StrCat(name, ": ", text);
  Return({order.order_id()}, text);
  if (absl::IsCancelled(status)) return;
  LogError("an order failed", {{"reason", text}});
  if (!IsHopeless(status)) return;
  MutexLock lock(mu_);
  fatal_.Update(absl::Status(status.code(), text));
  changed_.NotifyAll();
}

void Actor::ReportVerdict(const OutgoingSegment& segment,
                          const v1::PutSegmentResponse& response) {
  using Response = v1::PutSegmentResponse;
  metrics_.Count(response);
  metrics_.queue_bytes.Set(static_cast<double>(outbox_.bytes()));
  const std::string& verdict = Response::Verdict_Name(response.verdict());
  if (response.verdict() != Response::VERDICT_ACCEPTED &&
      response.verdict() != Response::VERDICT_DUPLICATE) {
    LogWarning("replay refused a segment", {{"order", segment.order_id},
                                            {"verdict", verdict},
                                            {"detail", response.detail()}});
  }
  if (IsRefusedForGood(response.verdict())) {
    Return({segment.order_id}, absl::StrCat(verdict, ": ", response.detail()),
           /*refused=*/true);
    return;
  }
  v1::ActorMessage::Done done;
  done.set_order_id(segment.order_id);
  done.set_issue(segment.issue);
  done.set_applied_version(segment.applied_version);
  done.set_apply_seconds(segment.apply_seconds);
  done.set_idle_seconds(segment.idle_seconds);
  done.set_blocked_seconds(segment.blocked_seconds);
  if (const auto connection = this->connection()) connection->SendDone(done);
}

void Actor::Return(const std::vector<int64_t>& order_ids,
                   const std::string& reason, bool refused) {
  if (order_ids.empty()) return;
  metrics_.orders_returned.Increment(static_cast<double>(order_ids.size()));
  if (const auto connection = this->connection()) {
    connection->SendReturn(order_ids, reason, refused);
  }
}

std::shared_ptr<Connection> Actor::AddHeld(int change) {
  MutexLock lock(mu_);
  held_ += change;
  metrics_.orders_held.Set(held_);
  return connection_;
}

bool Actor::WaitForWorkers(CondVar::TimePoint deadline) {
  MutexLock lock(mu_);
  while (working_ > 0) {
    if (!changed_.WaitUntil(mu_, deadline)) break;
  }
  return working_ == 0;
}

}  // namespace sinew::actor
