#ifndef SINEW_ACTOR_SERVICE_CONNECTION_H_
#define SINEW_ACTOR_SERVICE_CONNECTION_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "common/mutex.h"
#include "grpcpp/channel.h"
#include "learner/client/dispatch_stream.h"
#include "proto/sinew/v1/dispatch.pb.h"

namespace sinew::actor {

// One registration with the dispatcher, from welcome to the stream's end, with
// its reader and heartbeat threads.
//
// Thread-safety: any thread. Ownership: owns stream and threads; callbacks run
// on the reader thread and what they touch must outlive the connection.
// Blocking: Open; Stop, for milliseconds. Errors: DispatchStream's.
class Connection {
 public:
  struct Callbacks {
    std::function<void(v1::Order)> on_order;
    std::function<void(const std::string& reason)> on_drain;
    // The stream is over; ended() says why.
    std::function<void()> on_end;
  };

  // Registers; gives up after `timeout` or when stopped (CANCELLED).
  static absl::StatusOr<std::unique_ptr<Connection>> Open(
      std::shared_ptr<grpc::Channel> channel, const std::string& peer,
      const v1::ActorMessage::Register& request, absl::Duration timeout,
      const std::stop_token& stop);
  ~Connection();

  const v1::DispatcherMessage::Welcome& welcome() const { return welcome_; }

  // Starts both threads; once.
  void Start(Callbacks callbacks);

  // Messages; lost if the stream is broken, which on_end tells.
  void SendWant(int count);
  void SendDone(const v1::ActorMessage::Done& done);
  void SendReturn(const std::vector<int64_t>& order_ids,
                  const std::string& reason, bool refused);
  // Says goodbye; the learner then ends the stream.
  void Close();
  // Ends the stream at once, with whatever waits on it.
  void Cancel() { stream_.Cancel(); }
  // Cancels the stream and joins the threads: no callback comes later. By the
  // thread that started them, before the last reference goes.
  void Stop();

  // Why the stream ended (OUT_OF_RANGE: in good order); nullopt: it has not.
  std::optional<absl::Status> ended() const SINEW_EXCLUDES(mu_);
  // True if it ended by `deadline`.
  bool WaitForEnd(CondVar::TimePoint deadline) SINEW_EXCLUDES(mu_);

 private:
  Connection(std::shared_ptr<grpc::Channel> channel, const std::string& peer)
      : stream_(std::move(channel), peer) {}

  void Read();
  void Beat(const std::stop_token& stop) SINEW_EXCLUDES(mu_);

  learner::DispatchStream stream_;
  // Constant after Open and Start.
  v1::DispatcherMessage::Welcome welcome_;
  Callbacks callbacks_;
  mutable Mutex mu_;
  CondVar changed_;
  std::optional<absl::Status> ended_ SINEW_GUARDED_BY(mu_);
  std::jthread heart_;
  std::jthread reader_;
};

}  // namespace sinew::actor

#endif  // SINEW_ACTOR_SERVICE_CONNECTION_H_
