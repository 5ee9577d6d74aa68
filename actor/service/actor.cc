#include "actor/service/actor.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <stop_token>
#include <utility>

#include "absl/strings/str_cat.h"
#include "actor/service/peer_blobs.h"
#include "common/logging.h"
#include "common/rpc/channel.h"
#include "common/rpc/status.h"
#include "common/rpc/watchdog.h"
#include "common/status_macros.h"

namespace sinew::actor {
namespace {

constexpr int kProtocolVersion = 1;
// Orders per thread: one that runs, one that waits, so that nobody idles.
constexpr int kOrdersPerThread = 2;
// For the learner to end the stream after goodbye.
constexpr absl::Duration kGoodbye = absl::Seconds(5);
// The last attempt to connect gets that long.
constexpr absl::Duration kShortestConnect = absl::Seconds(1);

CondVar::TimePoint After(absl::Duration timeout) {
  return std::chrono::steady_clock::now() + absl::ToChronoNanoseconds(timeout);
}

absl::Duration Until(CondVar::TimePoint deadline) {
  return absl::FromChrono(deadline - std::chrono::steady_clock::now());
}

// Worth trying again: the peer is away, or ended the stream in good order.
bool MayReconnect(const absl::Status& status) {
  return rpc::IsTransient(status) || absl::IsOutOfRange(status);
}

}  // namespace

absl::StatusOr<std::unique_ptr<Actor>> Actor::Create(Options options,
                                                     Engine& engine,
                                                     ActorMetrics& metrics) {
  if (options.threads < 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("actor threads: expected >= 1, found ", options.threads));
  }
  if (options.outbox_bytes < 1) {
    return absl::InvalidArgumentError(absl::StrCat(
        "actor outbox bytes: expected >= 1, found ", options.outbox_bytes));
  }
  SINEW_RETURN_IF_ERROR(
      rpc::MakeChannel(options.dispatcher_address, options.security).status());
  return std::unique_ptr<Actor>(new Actor(std::move(options), engine, metrics));
}

Actor::Actor(Options options, Engine& engine, ActorMetrics& metrics)
    : options_(std::move(options)),
      capacity_(kOrdersPerThread * options_.threads),
      engine_(engine),
      metrics_(metrics),
      inputs_(engine, metrics),
      versions_(metrics),
      queue_(capacity_),
      outbox_(options_.outbox_bytes) {
  metrics_.threads.Set(options_.threads);
  metrics_.queue_limit_bytes.Set(static_cast<double>(options_.outbox_bytes));
}

Actor::~Actor() = default;

absl::Status Actor::Run(const StopToken& stop) {
  ReplaySender::Options sender_options;
  sender_options.backoff = options_.backoff;
  sender_ = std::make_unique<ReplaySender>(
      sender_options, outbox_, metrics_,
      [this](const auto& segment, const auto& response) {
        ReportVerdict(segment, response);
      });
  {
    MutexLock lock(mu_);
    working_ = options_.threads;
  }
  for (int i = 0; i < options_.threads; ++i) {
    workers_.emplace_back([this] { Work(); });
  }
  absl::Status status = Serve(stop);
  if (status.ok()) status = fatal();
  // Nobody waits for the segments of a learner that is gone.
  Finish(
      /*hand_back=*/stop.stop_requested() || !status.ok(),
      connection() == nullptr ? absl::ZeroDuration() : options_.drain_timeout);
  return status;
}

absl::Status Actor::Serve(const StopToken& stop) {
  rpc::Backoff backoff(options_.backoff, rpc::FreshSeed());
  absl::Duration left = options_.reconnect_timeout;
  CondVar::TimePoint deadline = After(left);
  while (true) {
    absl::Status status = Connect(
        std::min(options_.connect_timeout, std::max(left, kShortestConnect)),
        stop);
    if (status.ok()) {
      backoff.Reset();
      status = Attend(stop);
      if (status.ok()) return status;
      deadline = After(options_.reconnect_timeout);
    }
    Disconnect();
    if (stop.stop_requested()) return absl::OkStatus();
    if (!MayReconnect(status)) return status;
    left = Until(deadline);
    if (left <= absl::ZeroDuration()) return GaveUp(status);
    const absl::Duration wait = std::min(backoff.Next(), left);
    metrics_.reconnects.Increment();
    LogWarning("no stream to the dispatcher",
               {{"reason", status.message()},
                {"retry_seconds", absl::ToDoubleSeconds(wait)}});
    if (!rpc::WaitFor(wait, stop)) return absl::OkStatus();
    left = Until(deadline);
  }
}

absl::Status Actor::GaveUp(const absl::Status& last) const {
  // A handshake that fails looks like a peer that is away.
  const char* hint =
      options_.security.has_tls()
          ? "a learner closes streams with a certificate that its authority "
            "has not signed"
          : "a learner with TLS closes streams without it";
  return absl::UnavailableError(
      absl::StrCat("no learner at ", options_.dispatcher_address, " for ",
                   absl::FormatDuration(options_.reconnect_timeout),
                   "; last error: ", last.message(), " (", hint, ")"));
}

absl::Status Actor::Connect(absl::Duration timeout, const StopToken& stop) {
  SINEW_ASSIGN_OR_RETURN(
      const std::shared_ptr<grpc::Channel> channel,
      rpc::MakeChannel(options_.dispatcher_address, options_.security));
  v1::ActorMessage::Register request;
  request.set_protocol_version(kProtocolVersion);
  request.set_build(options_.build);
  request.set_mujoco_version(options_.mujoco_version);
  request.set_cpu_class(options_.cpu_class);
  request.set_threads(options_.threads);
  request.set_name(options_.name);
  SINEW_ASSIGN_OR_RETURN(
      const std::shared_ptr<Connection> opened,
      Connection::Open(channel,
                       absl::StrCat("dispatcher ", options_.dispatcher_address),
                       request, timeout, stop));
  const int want = Adopt(opened);
  SINEW_RETURN_IF_ERROR(UsePeers(opened->welcome(), stop));
  LogInfo("registered", {{"dispatcher", options_.dispatcher_address},
                         {"run", opened->welcome().run_id()},
                         {"threads", options_.threads}});
  if (want > 0) opened->SendWant(want);
  return absl::OkStatus();
}

int Actor::Adopt(std::shared_ptr<Connection> connection) {
  int want = 0;
  {
    MutexLock lock(mu_);
    connection_ = connection;
    want = capacity_ - held_;
  }
  Connection::Callbacks callbacks;
  callbacks.on_order = [this](v1::Order order) { TakeOrder(std::move(order)); };
  callbacks.on_drain = [this](const std::string& reason) {
    LogInfo("the learner drains", {{"reason", reason}});
    MutexLock lock(mu_);
    drained_ = true;
    changed_.NotifyAll();
  };
  callbacks.on_end = [this] {
    MutexLock lock(mu_);
    changed_.NotifyAll();
  };
  connection->Start(std::move(callbacks));
  return want;
}

absl::Status Actor::UsePeers(const v1::DispatcherMessage::Welcome& welcome,
                             const StopToken& stop) {
  const auto or_learner = [this](const std::string& address) {
    return address.empty() ? options_.dispatcher_address : address;
  };
  const std::string checkpoint = or_learner(welcome.checkpoint_address());
  const std::string replay = or_learner(welcome.replay_address());
  // Fetches end with the stop too: an actor that only waits may go at once.
  const std::stop_callback abandon(stop, [this] { abandon_.request_stop(); });
  const PeerBlobs::Options fetch = {.security = options_.security,
                                    .backoff = options_.backoff,
                                    .stop = abandon_.get_token()};
  SINEW_ASSIGN_OR_RETURN(
      std::shared_ptr<BlobSource> assets,
      PeerBlobs::Cached(checkpoint, fetch, options_.cache_folder,
                        options_.cache_bytes));
  SINEW_ASSIGN_OR_RETURN(std::shared_ptr<BlobSource> snapshots,
                         PeerBlobs::Direct(options_.dispatcher_address, fetch));
  inputs_.SetSources(std::move(assets), std::move(snapshots));
  SINEW_ASSIGN_OR_RETURN(std::shared_ptr<grpc::Channel> channel,
                         rpc::MakeChannel(replay, options_.security));
  sender_->SetPeer(std::move(channel), absl::StrCat("replay ", replay));
  if (welcome.assets_sha256().empty()) return absl::OkStatus();
  return inputs_.GetAssets(welcome.assets_sha256()).status();
}

absl::Status Actor::Attend(const StopToken& stop) {
  MutexLock lock(mu_);
  while (!drained_ && fatal_.ok()) {
    const std::optional<absl::Status> ended = connection_->ended();
    if (ended.has_value()) return *ended;
    if (!changed_.Wait(mu_, stop)) break;
  }
  return absl::OkStatus();
}

void Actor::Disconnect() {
  std::shared_ptr<Connection> old;
  {
    MutexLock lock(mu_);
    old = std::exchange(connection_, nullptr);
  }
  if (old != nullptr) old->Stop();
  AddHeld(-static_cast<int>(queue_.Clear().size()));
}

void Actor::TakeOrder(v1::Order order) {
  metrics_.orders_taken.Increment();
  versions_.Hear(order.snapshot_version(), std::chrono::steady_clock::now());
  const int64_t id = order.order_id();
  AddHeld(1);
  const absl::Status status = queue_.Push(std::move(order));
  if (status.ok()) return;
  AddHeld(-1);
  Return({id}, std::string(status.message()));
}

void Actor::Finish(bool hand_back, absl::Duration patience) {
  const CondVar::TimePoint deadline = After(patience);
  // A learner that reads no more must not hold up what is sent to it.
  const rpc::Watchdog late(patience + kGoodbye, [this] {
    if (const auto last = connection()) last->Cancel();
  });
  queue_.Close();
  if (hand_back) {
    // What is being fetched is for orders that have not begun.
    abandon_.request_stop();
    Return(queue_.Clear(), "the actor goes away");
  }
  const bool done =
      WaitForWorkers(deadline) && outbox_.WaitUntilEmpty(deadline);
  if (!done) LogWarning("not all orders were finished in time");
  cancel_ = true;
  abandon_.request_stop();
  Return(queue_.Clear(), "the actor goes away");
  Return(outbox_.Close(), "no verdict in time");
  workers_.clear();
  sender_ = nullptr;
  if (const std::shared_ptr<Connection> last = connection()) {
    last->Close();
    last->WaitForEnd(After(kGoodbye));
  }
  Disconnect();
}

absl::Status Actor::fatal() const {
  MutexLock lock(mu_);
  return fatal_;
}

std::shared_ptr<Connection> Actor::connection() const {
  MutexLock lock(mu_);
  return connection_;
}

}  // namespace sinew::actor
