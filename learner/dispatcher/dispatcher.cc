#include "learner/dispatcher/dispatcher.h"

#include <thread>
#include <utility>

#include "absl/status/status.h"
#include "common/check.h"
#include "common/mutex.h"
#include "learner/dispatcher/roster.h"
#include "learner/dispatcher/session.h"

namespace sinew::learner {
namespace {

// What actors at the end of Shutdown's patience are given to hear of it.
constexpr absl::Duration kFarewell = absl::Seconds(1);
// Cancelled streams end by themselves, soon; the bound is for our bugs.
constexpr absl::Duration kCancelled = absl::Seconds(4);

class DispatcherImpl final : public Dispatcher,
                             public SessionOwner,
                             public v1::Dispatcher::CallbackService {
 public:
  explicit DispatcherImpl(const Options& options)
      : on_apply_(options.on_apply),
        tick_period_(absl::Seconds(options.welcome.heartbeat_seconds() / 4)),
        clock_(options.clock != nullptr ? *options.clock : system_clock_),
        roster_(options, clock_),
        ticker_([this](const std::stop_token& stop) { Tick(stop); }) {}

  ~DispatcherImpl() override { Shutdown(absl::InfinitePast()); }

  grpc::Service* service() override { return this; }

  grpc::ServerBidiReactor<v1::ActorMessage, v1::DispatcherMessage>* Work(
      grpc::CallbackServerContext* context) override;

  void Add(const std::vector<v1::Order>& orders) override;
  void Retire(const std::vector<int64_t>& order_ids) override;
  std::vector<int64_t> Finished() const override;
  Statistics statistics() const override;
  absl::Status failure() const override;
  void Shutdown(absl::Time deadline) override;
  void Interrupt() override;

  void OnMessage(Session& session, bool ok) override;
  void OnWritten(Session& session, bool ok) override;
  void OnEnded(Session& session) override;

 private:
  // Reads on, with no lock held; BeginStartRead was called.
  void StartRead(Session& session);
  void Tick(const std::stop_token& stop);
  void AwaitSessions(absl::Duration patience);

  const std::function<void(double seconds)> on_apply_;
  const absl::Duration tick_period_;
  SystemClock system_clock_;
  Clock& clock_;
  mutable Mutex mu_;
  CondVar changed_;
  CondVar tick_;
  Roster roster_ SINEW_GUARDED_BY(mu_);
  int64_t next_session_ SINEW_GUARDED_BY(mu_) = 1;
  // Last: the thread uses all of the above.
  std::jthread ticker_;
};

grpc::ServerBidiReactor<v1::ActorMessage, v1::DispatcherMessage>*
DispatcherImpl::Work(grpc::CallbackServerContext* context) {
  Session* session = nullptr;
  SessionActions actions;
  bool read_on = false;
  {
    MutexLock lock(mu_);
    session = new Session(*this, *context, next_session_++);
    roster_.Enter(*session);
    read_on = !session->closing();
    if (read_on) session->BeginStartRead();
    session->Collect(actions);
  }
  actions.Run();
  if (read_on) StartRead(*session);
  return session;
}

void DispatcherImpl::StartRead(Session& session) {
  session.StartRead(&session.incoming);
  SessionActions actions;
  {
    MutexLock lock(mu_);
    session.EndStartRead();
    session.Collect(actions);
  }
  actions.Run();
}

void DispatcherImpl::Add(const std::vector<v1::Order>& orders) {
  SessionActions actions;
  {
    MutexLock lock(mu_);
    roster_.AddOrders(orders);
    roster_.Advance(actions);
  }
  actions.Run();
}

void DispatcherImpl::Retire(const std::vector<int64_t>& order_ids) {
  SessionActions actions;
  {
    MutexLock lock(mu_);
    roster_.RetireOrders(order_ids);
    roster_.Advance(actions);
  }
  actions.Run();
}

std::vector<int64_t> DispatcherImpl::Finished() const {
  MutexLock lock(mu_);
  return roster_.finished_orders();
}

Dispatcher::Statistics DispatcherImpl::statistics() const {
  MutexLock lock(mu_);
  return roster_.statistics();
}

absl::Status DispatcherImpl::failure() const {
  MutexLock lock(mu_);
  return roster_.failure();
}

void DispatcherImpl::OnMessage(Session& session, bool ok) {
  SessionActions actions;
  bool read_on = false;
  bool applied = false;
  double apply_seconds = 0;
  {
    MutexLock lock(mu_);
    const int64_t version = session.applied_version;
    if (ok) {
      roster_.Handle(session, session.incoming);
    } else {
      roster_.Close(session, absl::OkStatus());
    }
    applied = session.applied_version > version;
    if (applied) apply_seconds = roster_.statistics().apply_seconds;
    read_on = !session.closing();
    if (read_on) session.BeginStartRead();
    roster_.Advance(actions);
  }
  actions.Run();
  if (applied && on_apply_) on_apply_(apply_seconds);
  if (read_on) StartRead(session);
}

void DispatcherImpl::OnWritten(Session& session, bool ok) {
  SessionActions actions;
  {
    MutexLock lock(mu_);
    session.EndWrite();
    if (!ok) {
      session.DropQueue();
      roster_.Close(session, absl::CancelledError("the stream is broken"));
    }
    roster_.Advance(actions);
  }
  actions.Run();
}

void DispatcherImpl::OnEnded(Session& session) {
  SessionActions actions;
  {
    MutexLock lock(mu_);
    roster_.Leave(session);
    roster_.Advance(actions);
    // Under the lock, so that Shutdown's waiter finds this object whole; with
    // the last session gone, it may be gone once the lock is dropped.
    changed_.NotifyAll();
  }
  actions.Run();
  delete &session;
}

void DispatcherImpl::Tick(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    SessionActions actions;
    {
      MutexLock lock(mu_);
      clock_.WaitUntil(mu_, tick_, clock_.After(tick_period_), stop);
      roster_.CloseSilent();
      roster_.Advance(actions);
    }
    actions.Run();
  }
}

void DispatcherImpl::Shutdown(absl::Time deadline) {
  SessionActions actions;
  {
    MutexLock lock(mu_);
    if (!roster_.draining()) {
      roster_.Drain();
      roster_.Advance(actions);
    }
  }
  actions.Run();
  AwaitSessions(deadline - clock_.WallNow());
  Interrupt();
  AwaitSessions(kFarewell);
  {
    MutexLock lock(mu_);
    roster_.CancelAll();
  }
  AwaitSessions(kCancelled);
  ticker_.request_stop();
  if (ticker_.joinable()) ticker_.join();
}

void DispatcherImpl::Interrupt() {
  SessionActions actions;
  {
    MutexLock lock(mu_);
    roster_.Interrupt();
    roster_.Advance(actions);
  }
  actions.Run();
}

void DispatcherImpl::AwaitSessions(absl::Duration patience) {
  if (patience <= absl::ZeroDuration()) return;
  const auto until = clock_.After(patience);
  MutexLock lock(mu_);
  while (!roster_.empty()) {
    if (!clock_.WaitUntil(mu_, changed_, until, {})) break;
  }
}

}  // namespace

std::unique_ptr<Dispatcher> Dispatcher::Create(const Options& options) {
  SINEW_CHECK(options.welcome.heartbeat_seconds() > 0)
      << options.welcome.heartbeat_seconds();
  return std::make_unique<DispatcherImpl>(options);
}

}  // namespace sinew::learner
