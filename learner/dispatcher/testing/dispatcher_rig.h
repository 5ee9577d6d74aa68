#ifndef SINEW_LEARNER_DISPATCHER_TESTING_DISPATCHER_RIG_H_
#define SINEW_LEARNER_DISPATCHER_TESTING_DISPATCHER_RIG_H_

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/clock.h"
#include "common/mutex.h"
#include "common/rpc/server.h"
#include "common/rpc/testing/socket_folder.h"
#include "common/rpc/watchdog.h"
#include "learner/client/dispatch_stream.h"
#include "learner/dispatcher/dispatcher.h"

namespace sinew::learner {

// A dispatcher behind a unix socket, with a heartbeat of 10 s and late orders
// at 20 s of the given clock.
//
// Thread-safety: any thread. Ownership: streams of TestActor end before it.
// Blocking: the destructor shuts down. Errors: test failures.
class DispatcherRig {
 public:
  explicit DispatcherRig(Clock& clock);
  ~DispatcherRig();

  Dispatcher& dispatcher() { return *dispatcher_; }
  const std::string& address() const { return server_->address(); }

  // Times that on_apply was called with `seconds`; waits for `count` of them.
  void AwaitApplied(double seconds, int count) SINEW_EXCLUDES(mu_);

 private:
  Mutex mu_;
  CondVar changed_;
  std::vector<double> applied_ SINEW_GUARDED_BY(mu_);
  rpc::SocketFolder folder_;
  std::unique_ptr<Dispatcher> dispatcher_;
  std::unique_ptr<rpc::Server> server_;
};

// What DispatcherRig admits.
v1::ActorMessage::Register MakeRegister(const std::string& name);

// Orders with nothing but an id.
std::vector<v1::Order> MakeOrders(std::initializer_list<int64_t> ids);

// An actor that does what the test says. Its stream is cancelled, with a test
// failure, if the test hangs for a minute.
class TestActor {
 public:
  TestActor(DispatcherRig& rig, const std::string& name);

  absl::StatusOr<v1::DispatcherMessage::Welcome> Register(
      const v1::ActorMessage::Register& request);
  // Registers as MakeRegister says; a test failure if refused.
  void Join();
  void Want(int count);
  // Of the order as ReadOrder read it last.
  void Done(int64_t order_id);
  void Done(const v1::Order& order);
  void Return(std::vector<int64_t> order_ids);
  // Replay refused its segment for `reason`.
  void Refuse(int64_t order_id, const std::string& reason);
  void Heartbeat();
  void Send(const v1::ActorMessage& message);
  // Returns once the dispatcher has handled all that was sent before.
  void Sync();

  // Id of the order that comes next; nullopt: something else came.
  std::optional<int64_t> ReadOrder();
  bool ReadDrain();
  // Status after the end of the stream; a test failure if a message comes.
  absl::Status ReadEnd();

  DispatchStream& stream() { return stream_; }

 private:
  DispatcherRig& rig_;
  const std::string name_;
  int64_t version_ = 0;
  std::map<int64_t, int64_t> issues_;  // by order id
  DispatchStream stream_;
  const rpc::Watchdog watchdog_;
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_DISPATCHER_TESTING_DISPATCHER_RIG_H_
