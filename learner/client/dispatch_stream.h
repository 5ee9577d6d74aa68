#ifndef SINEW_LEARNER_CLIENT_DISPATCH_STREAM_H_
#define SINEW_LEARNER_CLIENT_DISPATCH_STREAM_H_

#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "common/mutex.h"
#include "grpcpp/channel.h"
#include "grpcpp/client_context.h"
#include "grpcpp/support/sync_stream.h"
#include "proto/sinew/v1/dispatch.grpc.pb.h"

namespace sinew::learner {

// An actor's stream to the dispatcher (dispatch.proto).
//
//   Register -> welcome
//   Send(want 4)
//   Read -> order, order, ...      Send(heartbeat), Send(done), Send(want 1)
//   Read -> drain                  Send(done) ...
//   Read -> OUT_OF_RANGE           (the learner ended the stream)
//
// Thread-safety: any thread sends and cancels, one reads. Ownership: shares
// the channel. Blocking: Register up to its timeout; Read until a message,
// CloseWrites' answer or Cancel; Send for as long as the peer does not read,
// which Cancel ends. Errors: name the peer; FAILED_PRECONDITION: not admitted;
// UNAVAILABLE and such: the stream is over, start another one.
class DispatchStream {
 public:
  // `peer` says who it is in errors, e.g. "dispatcher unix:/run/d.sock".
  DispatchStream(std::shared_ptr<grpc::Channel> channel, std::string peer);
  // Cancels.
  ~DispatchStream();
  DispatchStream(const DispatchStream&) = delete;
  DispatchStream& operator=(const DispatchStream&) = delete;

  // First of all. By the reading thread.
  absl::StatusOr<v1::DispatcherMessage::Welcome> Register(
      const v1::ActorMessage::Register& request, absl::Duration timeout);

  // False: the stream is broken; Read says why.
  bool Send(const v1::ActorMessage& message) SINEW_EXCLUDES(mu_);

  // The next message. OUT_OF_RANGE: the stream ended in good order.
  absl::StatusOr<v1::DispatcherMessage> Read();

  // The actor goes away; nothing is sent afterwards.
  void CloseWrites() SINEW_EXCLUDES(mu_);

  void Cancel();

 private:
  using Stream =
      grpc::ClientReaderWriter<v1::ActorMessage, v1::DispatcherMessage>;

  const std::unique_ptr<v1::Dispatcher::Stub> stub_;
  const std::string peer_;
  grpc::ClientContext context_;
  // One write at a time.
  Mutex mu_;
  bool writes_closed_ SINEW_GUARDED_BY(mu_) = false;
  const std::unique_ptr<Stream> stream_;
  // By the reader.
  bool finished_ = false;
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_CLIENT_DISPATCH_STREAM_H_
