#include "learner/client/dispatch_stream.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "common/rpc/status.h"
#include "common/rpc/watchdog.h"
#include "common/status_macros.h"

namespace sinew::learner {

DispatchStream::DispatchStream(std::shared_ptr<grpc::Channel> channel,
                               std::string peer)
    : stub_(v1::Dispatcher::NewStub(std::move(channel))),
      peer_(std::move(peer)),
      stream_(stub_->Work(&context_)) {}

DispatchStream::~DispatchStream() {
  context_.TryCancel();
  if (!finished_) stream_->Finish().ok();
}

absl::StatusOr<v1::DispatcherMessage::Welcome> DispatchStream::Register(
    const v1::ActorMessage::Register& request, absl::Duration timeout) {
  const rpc::Watchdog watchdog(timeout, [this] { Cancel(); });
  v1::ActorMessage message;
  *message.mutable_register_() = request;
  // A broken stream shows when it is read.
  Send(message);
  absl::StatusOr<v1::DispatcherMessage> answer = Read();
  if (watchdog.has_expired()) {
    return absl::DeadlineExceededError(absl::StrCat(
        peer_, ": no welcome within ", absl::FormatDuration(timeout)));
  }
  if (!answer.ok()) return answer.status();
  if (!answer->has_welcome()) {
    return absl::InternalError(
        absl::StrCat(peer_, ": expected a welcome first, found message ",
                     static_cast<int>(answer->message_case())));
  }
  return std::move(*answer->mutable_welcome());
}

bool DispatchStream::Send(const v1::ActorMessage& message) {
  MutexLock lock(mu_);
  return !writes_closed_ && stream_->Write(message);
}

absl::StatusOr<v1::DispatcherMessage> DispatchStream::Read() {
  v1::DispatcherMessage message;
  if (stream_->Read(&message)) return message;
  finished_ = true;
  SINEW_RETURN_IF_ERROR(rpc::FromGrpc(stream_->Finish(), peer_));
  return absl::OutOfRangeError(absl::StrCat(peer_, ": end of stream"));
}

void DispatchStream::CloseWrites() {
  MutexLock lock(mu_);
  if (!std::exchange(writes_closed_, true)) stream_->WritesDone();
}

void DispatchStream::Cancel() { context_.TryCancel(); }

}  // namespace sinew::learner
