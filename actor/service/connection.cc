#include "actor/service/connection.h"

#include <algorithm>
#include <utility>

#include "common/rpc/retry.h"
#include "common/status_macros.h"

namespace sinew::actor {
namespace {

constexpr double kShortestHeartbeatSeconds = 0.01;

}  // namespace

absl::StatusOr<std::unique_ptr<Connection>> Connection::Open(
    std::shared_ptr<grpc::Channel> channel, const std::string& peer,
    const v1::ActorMessage::Register& request, absl::Duration timeout,
    const std::stop_token& stop) {
  std::unique_ptr<Connection> connection(
      new Connection(std::move(channel), peer));
  learner::DispatchStream& stream = connection->stream_;
  const std::stop_callback cancel(stop, [&stream] { stream.Cancel(); });
  SINEW_ASSIGN_OR_RETURN(connection->welcome_,
                         stream.Register(request, timeout));
  return connection;
}

Connection::~Connection() { Stop(); }

void Connection::Stop() {
  stream_.Cancel();
  heart_.request_stop();
  if (heart_.joinable()) heart_.join();
  if (reader_.joinable()) reader_.join();
}

void Connection::Start(Callbacks callbacks) {
  callbacks_ = std::move(callbacks);
  heart_ = std::jthread([this](const std::stop_token& stop) { Beat(stop); });
  reader_ = std::jthread([this] { Read(); });
}

void Connection::Read() {
  absl::StatusOr<v1::DispatcherMessage> message = stream_.Read();
  for (; message.ok(); message = stream_.Read()) {
    if (message->has_order()) {
      callbacks_.on_order(std::move(*message->mutable_order()));
    } else if (message->has_drain()) {
      callbacks_.on_drain(message->drain().reason());
    }
  }
  {
    MutexLock lock(mu_);
    ended_ = message.status();
    changed_.NotifyAll();
  }
  callbacks_.on_end();
}

void Connection::Beat(const std::stop_token& stop) {
  const absl::Duration period = absl::Seconds(
      std::max(kShortestHeartbeatSeconds, welcome_.heartbeat_seconds()));
  v1::ActorMessage message;
  message.mutable_heartbeat();
  while (rpc::WaitFor(period, stop) && stream_.Send(message)) {
  }
}

void Connection::SendWant(int count) {
  v1::ActorMessage message;
  message.mutable_want()->set_count(count);
  stream_.Send(message);
}

void Connection::SendDone(const v1::ActorMessage::Done& done) {
  v1::ActorMessage message;
  *message.mutable_done() = done;
  stream_.Send(message);
}

void Connection::SendReturn(const std::vector<int64_t>& order_ids,
                            const std::string& reason, bool refused) {
  if (order_ids.empty()) return;
  v1::ActorMessage message;
  message.mutable_return_()->mutable_order_ids()->Add(order_ids.begin(),
                                                      order_ids.end());
  message.mutable_return_()->set_reason(reason);
  message.mutable_return_()->set_refused(refused);
  stream_.Send(message);
}

void Connection::Close() { stream_.CloseWrites(); }

std::optional<absl::Status> Connection::ended() const {
  MutexLock lock(mu_);
  return ended_;
}

bool Connection::WaitForEnd(CondVar::TimePoint deadline) {
  MutexLock lock(mu_);
  while (!ended_.has_value()) {
    if (!changed_.WaitUntil(mu_, deadline)) break;
  }
  return ended_.has_value();
}

}  // namespace sinew::actor
