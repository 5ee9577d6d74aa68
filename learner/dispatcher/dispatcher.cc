#include "learner/dispatcher/dispatcher.h"

#include <algorithm>
#include <deque>
#include <map>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/time/clock.h"
#include "common/mutex.h"
#include "grpcpp/grpcpp.h"
#include "learner/dispatcher/order_pool.h"

namespace sinew::learner {
namespace {

constexpr int kProtocolVersion = 1;
// Heartbeats an actor may miss before its leases end.
constexpr double kMissedHeartbeats = 3;
// Orders one actor may ask for; a bound against nonsense, far above need.
constexpr int64_t kMaxWant = 1024;

class DispatcherImpl;

// One actor's stream. All fields but the two messages are guarded by the
// dispatcher's mutex. gRPC may call reactions from within Start*, so those are
// called with no lock held; `writing` and `finishing` say who may call them.
class Session
    : public grpc::ServerBidiReactor<v1::ActorMessage, v1::DispatcherMessage> {
 public:
  Session(DispatcherImpl& dispatcher, grpc::CallbackServerContext& context,
          int64_t id)
      : dispatcher(dispatcher), context(context), id(id) {}

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnDone() override;

  DispatcherImpl& dispatcher;
  grpc::CallbackServerContext& context;
  const int64_t id;

  v1::ActorMessage incoming;
  v1::DispatcherMessage outgoing;

  std::deque<v1::DispatcherMessage> queue;
  bool registered = false;
  bool writing = false;
  // A thread is about to call StartRead: until it has, the call must not end,
  // since the session goes with it.
  bool starting_read = false;
  bool closing = false;    // nothing more will be read; finish when written
  bool finishing = false;  // Finish was or is being called
  grpc::Status final_status;
  int64_t want = 0;
  int threads = 0;
  absl::Time last_heard;
};

// What must be done once the lock is dropped.
struct Actions {
  std::vector<Session*> write;
  std::vector<Session*> finish;
  std::vector<Session*> cancel;

  void Run() {
    for (Session* session : write) session->StartWrite(&session->outgoing);
    for (Session* session : finish) session->Finish(session->final_status);
    for (Session* session : cancel) session->context.TryCancel();
  }
};

class DispatcherImpl final : public Dispatcher,
                             public v1::Dispatcher::CallbackService {
 public:
  explicit DispatcherImpl(const Options& options)
      : options_(options),
        pool_(options.reissue_after),
        ticker_([this](std::stop_token stop) { Tick(stop); }) {}

  ~DispatcherImpl() override { Shutdown(absl::Now()); }

  grpc::Service* service() override { return this; }

  grpc::ServerBidiReactor<v1::ActorMessage, v1::DispatcherMessage>* Work(
      grpc::CallbackServerContext* context) override {
    Session* session = nullptr;
    Actions actions;
    {
      MutexLock lock(mu_);
      session = new Session(*this, *context, next_session_++);
      session->last_heard = absl::Now();
      sessions_[session->id] = session;
      if (draining_) {
        Close(*session, grpc::Status(grpc::StatusCode::UNAVAILABLE,
                                     "the learner is going away"));
        Collect(*session, actions);
      }
    }
    actions.Run();
    if (actions.finish.empty()) session->StartRead(&session->incoming);
    return session;
  }

  void Add(const std::vector<v1::Order>& orders) override {
    Actions actions;
    {
      MutexLock lock(mu_);
      pool_.Add(orders);
      Match(actions);
    }
    actions.Run();
  }

  void Retire(const std::vector<int64_t>& order_ids) override {
    MutexLock lock(mu_);
    pool_.Retire(order_ids);
  }

  Statistics statistics() const override {
    MutexLock lock(mu_);
    Statistics result = totals_;
    result.actors = 0;
    result.threads = 0;
    for (const auto& [id, session] : sessions_) {
      if (!session->registered) continue;
      ++result.actors;
      result.threads += session->threads;
    }
    result.orders_waiting = pool_.waiting();
    result.orders_leased = pool_.leased();
    result.orders_reissued = pool_.reissued();
    return result;
  }

  void Shutdown(absl::Time deadline) override {
    Actions actions;
    {
      MutexLock lock(mu_);
      draining_ = true;
      for (auto& [id, session] : sessions_) {
        v1::DispatcherMessage message;
        message.mutable_drain()->set_reason("the learner has finished");
        session->queue.push_back(std::move(message));
        Collect(*session, actions);
      }
    }
    actions.Run();
    AwaitSessionsUntil(deadline);
    CancelAll();
    // Cancelled streams end by themselves, soon; the bound is for our bugs.
    AwaitSessionsUntil(absl::Now() + absl::Seconds(5));
    ticker_.request_stop();
    if (ticker_.joinable()) ticker_.join();
  }

  // Reactions of a session. ---------------------------------------------------

  void OnMessage(Session& session, bool ok) {
    Actions actions;
    bool read_on = false;
    {
      MutexLock lock(mu_);
      session.last_heard = absl::Now();
      if (!ok) {
        Close(session, grpc::Status::OK);
      } else {
        Handle(session, session.incoming);
        read_on = !session.closing;
        session.starting_read = read_on;
      }
      Match(actions);
      Collect(session, actions);
    }
    actions.Run();
    if (!read_on) return;
    session.StartRead(&session.incoming);
    Actions after;
    {
      MutexLock lock(mu_);
      session.starting_read = false;
      Collect(session, after);
    }
    after.Run();
  }

  void OnWritten(Session& session, bool ok) {
    Actions actions;
    {
      MutexLock lock(mu_);
      session.writing = false;
      if (!ok) {
        session.queue.clear();
        Close(session, grpc::Status::CANCELLED);
      }
      Collect(session, actions);
    }
    actions.Run();
  }

  void OnSessionDone(Session& session) {
    Actions actions;
    {
      MutexLock lock(mu_);
      if (pool_.held_by(session.id) > 0) ++totals_.lost_actors;
      pool_.Forget(session.id);
      sessions_.erase(session.id);
      Match(actions);
      // Under the lock, so that Shutdown's waiter finds this object whole.
      changed_.NotifyAll();
    }
    actions.Run();
    delete &session;
  }

 private:
  void Handle(Session& session, const v1::ActorMessage& message)
      SINEW_REQUIRES(mu_) {
    if (!session.registered) {
      Admit(session, message);
      return;
    }
    switch (message.message_case()) {
      case v1::ActorMessage::kWant:
        if (message.want().count() < 1) {
          Close(session,
                grpc::Status(grpc::StatusCode::INVALID_ARGUMENT,
                             absl::StrCat("want.count: expected >= 1, found ",
                                          message.want().count())));
          return;
        }
        session.want =
            std::min(kMaxWant, session.want + message.want().count());
        return;
      case v1::ActorMessage::kHeartbeat:
        return;
      case v1::ActorMessage::kDone:
        pool_.Finish(session.id, message.done().order_id());
        totals_.applied_version =
            std::max(totals_.applied_version, message.done().applied_version());
        totals_.apply_seconds = message.done().apply_seconds();
        totals_.idle_seconds += message.done().idle_seconds();
        totals_.blocked_seconds += message.done().blocked_seconds();
        return;
      case v1::ActorMessage::kReturn:
        for (int64_t id : message.return_().order_ids()) {
          pool_.Return(session.id, id);
        }
        return;
      default:
        Close(session, grpc::Status(grpc::StatusCode::INVALID_ARGUMENT,
                                    "expected want, heartbeat, done or return "
                                    "after register"));
    }
  }

  void Admit(Session& session, const v1::ActorMessage& message)
      SINEW_REQUIRES(mu_) {
    if (!message.has_register_()) {
      ++totals_.refused_actors;
      Close(session, grpc::Status(grpc::StatusCode::FAILED_PRECONDITION,
                                  "expected register as first message"));
      return;
    }
    const auto& actor = message.register_();
    const std::string mismatch = Mismatch(actor);
    if (!mismatch.empty()) {
      ++totals_.refused_actors;
      Close(session, grpc::Status(
                         grpc::StatusCode::FAILED_PRECONDITION,
                         absl::StrCat("actor ", actor.name(), ": ", mismatch)));
      return;
    }
    session.registered = true;
    session.threads = actor.threads();
    v1::DispatcherMessage welcome;
    *welcome.mutable_welcome() = options_.welcome;
    session.queue.push_back(std::move(welcome));
  }

  // Empty if the actor may join; otherwise what was expected and found.
  std::string Mismatch(const v1::ActorMessage::Register& actor) const {
    const auto differs = [](absl::string_view field, absl::string_view expected,
                            absl::string_view found) {
      return absl::StrCat(field, ": expected ", expected, ", found ", found);
    };
    if (actor.protocol_version() != kProtocolVersion) {
      return differs("protocol version", absl::StrCat(kProtocolVersion),
                     absl::StrCat(actor.protocol_version()));
    }
    if (actor.build() != options_.build) {
      return differs("build", options_.build, actor.build());
    }
    if (actor.mujoco_version() != options_.mujoco_version) {
      return differs("MuJoCo version", options_.mujoco_version,
                     actor.mujoco_version());
    }
    if (actor.cpu_class() != options_.cpu_class) {
      return differs("CPU class", options_.cpu_class, actor.cpu_class());
    }
    if (actor.threads() < 1) {
      return differs("threads", ">= 1", absl::StrCat(actor.threads()));
    }
    return "";
  }

  void Close(Session& session, const grpc::Status& status)
      SINEW_REQUIRES(mu_) {
    if (session.closing) return;
    session.closing = true;
    session.want = 0;
    session.final_status = status;
    pool_.Forget(session.id);
  }

  // Gives waiting orders to actors that want some, fairly: one each in turn.
  void Match(Actions& actions) SINEW_REQUIRES(mu_) {
    if (draining_) return;
    const absl::Time now = absl::Now();
    bool progress = true;
    while (progress) {
      progress = false;
      for (auto& [id, session] : sessions_) {
        if (session->want == 0 || session->closing) continue;
        std::optional<v1::Order> order = pool_.Assign(id, now);
        if (!order) continue;
        v1::DispatcherMessage message;
        *message.mutable_order() = *std::move(order);
        session->queue.push_back(std::move(message));
        --session->want;
        progress = true;
      }
    }
    for (auto& [id, session] : sessions_) Collect(*session, actions);
  }

  // Adds to `actions` what the session may start now.
  void Collect(Session& session, Actions& actions) SINEW_REQUIRES(mu_) {
    if (session.writing || session.finishing) return;
    if (!session.queue.empty()) {
      session.outgoing = std::move(session.queue.front());
      session.queue.pop_front();
      session.writing = true;
      actions.write.push_back(&session);
    } else if (session.closing && !session.starting_read) {
      session.finishing = true;
      actions.finish.push_back(&session);
    }
  }

  void Tick(std::stop_token stop) {
    const auto period = std::chrono::duration<double>(
        options_.welcome.heartbeat_seconds() / 4);
    while (!stop.stop_requested()) {
      Actions actions;
      {
        MutexLock lock(mu_);
        tick_.WaitUntil(mu_,
                        std::chrono::steady_clock::now() +
                            std::chrono::duration_cast<
                                std::chrono::steady_clock::duration>(period),
                        stop);
        const absl::Time silent_since =
            absl::Now() - kMissedHeartbeats *
                              absl::Seconds(
                                  options_.welcome.heartbeat_seconds());
        for (auto& [id, session] : sessions_) {
          if (session->last_heard < silent_since && !session->finishing) {
            pool_.Forget(id);
            actions.cancel.push_back(session);
          }
        }
        Match(actions);
        // Cancelling under the lock is safe: it only marks the call.
        for (Session* session : actions.cancel) session->context.TryCancel();
        actions.cancel.clear();
      }
      actions.Run();
    }
  }

  void CancelAll() {
    MutexLock lock(mu_);
    for (auto& [id, session] : sessions_) session->context.TryCancel();
  }

  void AwaitSessionsUntil(absl::Time deadline) {
    const auto until = absl::ToChronoTime(deadline);
    const auto left = until - std::chrono::system_clock::now();
    const auto steady =
        std::chrono::steady_clock::now() +
        std::chrono::duration_cast<std::chrono::steady_clock::duration>(left);
    MutexLock lock(mu_);
    while (!sessions_.empty()) {
      if (!changed_.WaitUntil(mu_, steady)) break;
    }
  }

  const Options options_;
  mutable Mutex mu_;
  CondVar changed_;
  CondVar tick_;
  OrderPool pool_ SINEW_GUARDED_BY(mu_);
  std::map<int64_t, Session*> sessions_ SINEW_GUARDED_BY(mu_);
  int64_t next_session_ SINEW_GUARDED_BY(mu_) = 1;
  bool draining_ SINEW_GUARDED_BY(mu_) = false;
  Statistics totals_ SINEW_GUARDED_BY(mu_);
  std::jthread ticker_;
};

void Session::OnReadDone(bool ok) { dispatcher.OnMessage(*this, ok); }
void Session::OnWriteDone(bool ok) { dispatcher.OnWritten(*this, ok); }
void Session::OnDone() { dispatcher.OnSessionDone(*this); }

}  // namespace

std::unique_ptr<Dispatcher> Dispatcher::Create(const Options& options) {
  return std::make_unique<DispatcherImpl>(options);
}

}  // namespace sinew::learner
