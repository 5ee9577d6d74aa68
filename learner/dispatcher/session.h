#ifndef SINEW_LEARNER_DISPATCHER_SESSION_H_
#define SINEW_LEARNER_DISPATCHER_SESSION_H_

#include <chrono>
#include <cstdint>
#include <deque>
#include <vector>

#include "absl/status/status.h"
#include "grpcpp/server_context.h"
#include "grpcpp/support/server_callback.h"
#include "grpcpp/support/status.h"
#include "proto/sinew/v1/dispatch.grpc.pb.h"

namespace sinew::learner {

class Session;

// What hears of a session's reactions: the dispatcher. Called on gRPC's
// threads, with no lock held.
class SessionOwner {
 public:
  // session.incoming was read; not ok: nothing more comes.
  virtual void OnMessage(Session& session, bool ok) = 0;
  // A message is with the transport; not ok: nothing more can be sent.
  virtual void OnWritten(Session& session, bool ok) = 0;
  // The last reaction: the owner forgets and deletes the session.
  virtual void OnEnded(Session& session) = 0;

 protected:
  ~SessionOwner() = default;
};

// What is to be started once the owner's lock is dropped: gRPC may call
// reactions from within its Start functions, and reactions take the lock.
struct SessionActions {
  std::vector<Session*> write;
  std::vector<Session*> finish;

  void Run();
};

// One actor's stream: which of its gRPC operations may be started, and what is
// known of the actor.
//
//   Push(m1) Push(m2) -> write m1 -> OnWritten -> write m2 -> OnWritten
//   Close(status)     -> what is queued is written, then Finish(status)
//
// Thread-safety: all but the reactions under the owner's mutex, which also
// guards the public fields; StartRead of the base and SessionActions::Run
// outside it. Ownership: made by the owner, which deletes it in OnEnded; lives
// at least until then, and gRPC calls OnEnded only after Finish was started
// and all reactions have returned. Blocking: never. Errors: none.
class Session
    : public grpc::ServerBidiReactor<v1::ActorMessage, v1::DispatcherMessage> {
 public:
  Session(SessionOwner& owner, grpc::CallbackServerContext& context, int64_t id)
      : id(id), owner_(owner), context_(context) {}

  // Queues a message, unless the stream is closing.
  void Push(v1::DispatcherMessage message);
  // Takes the orders that are queued and not yet being written out again.
  std::vector<int64_t> DropQueuedOrders();
  // The stream ends with `status` once the queue is written; what is read from
  // now on has no effect. Only the first call counts.
  void Close(const absl::Status& status);
  // The queue cannot be written any more.
  void DropQueue() { queue_.clear(); }

  // A thread is about to call StartRead: until EndStartRead, the call is not
  // finished (starting an operation afterwards is forbidden).
  void BeginStartRead() { ++reads_being_started_; }
  void EndStartRead() { --reads_being_started_; }
  void EndWrite() { writing_ = false; }
  // Adds what may be started now, and marks it as started.
  void Collect(SessionActions& actions);
  // Every operation of the stream fails soon. Safe under the owner's mutex:
  // away from gRPC's threads it only marks the call.
  void Cancel() { context_.TryCancel(); }

  bool closing() const { return closing_; }

  const int64_t id;
  v1::ActorMessage incoming;
  bool registered = false;
  int threads = 0;
  int64_t want = 0;
  int64_t applied_version = -1;
  std::chrono::steady_clock::time_point last_heard;

 private:
  friend struct SessionActions;

  void OnReadDone(bool ok) override { owner_.OnMessage(*this, ok); }
  void OnWriteDone(bool ok) override { owner_.OnWritten(*this, ok); }
  void OnDone() override { owner_.OnEnded(*this); }

  SessionOwner& owner_;
  grpc::CallbackServerContext& context_;
  v1::DispatcherMessage outgoing_;
  std::deque<v1::DispatcherMessage> queue_;
  // A read may be done, and its reaction start the next, before the call that
  // started it has returned.
  int reads_being_started_ = 0;
  bool writing_ = false;
  bool closing_ = false;
  bool finishing_ = false;  // Finish was or is being called
  grpc::Status final_status_;
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_DISPATCHER_SESSION_H_
