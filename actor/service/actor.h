#ifndef SINEW_ACTOR_SERVICE_ACTOR_H_
#define SINEW_ACTOR_SERVICE_ACTOR_H_

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "actor/service/actor_metrics.h"
#include "actor/service/applied_versions.h"
#include "actor/service/connection.h"
#include "actor/service/engine.h"
#include "actor/service/order_inputs.h"
#include "actor/service/order_queue.h"
#include "actor/service/order_runner.h"
#include "actor/service/outbox.h"
#include "actor/service/replay_sender.h"
#include "common/mutex.h"
#include "common/rpc/credentials.h"
#include "common/rpc/retry.h"
#include "common/stop.h"

namespace sinew::actor {

// An actor: takes orders from the dispatcher, runs them on its threads, sends
// the segments to replay. It holds nothing that is not in an order, a blob or
// a segment: it may start in an empty folder and die at any moment.
//
//   1. connect, register, fetch the assets; want 2 orders per thread
//   2. each thread: pop an order, fetch its snapshot, roll out, push the
//      segment into the outbox (waits while replay is full), want 1
//   3. each verdict of replay: done; refused for good: give the order back
//   until stop:           give back what was not begun; finish what runs and
//                         send it, or give it back after drain_timeout
//   until learner drains: finish everything, send it, go
//   stream broke:         forget what was not begun (the learner gives it out
//                         again), back off, go to 1; segments keep flowing;
//                         after reconnect_timeout without a learner, end with
//                         an error that names it
//   an order that cannot work with this build: give it back, end with the error
//   another failure (a blob is gone): give the order back, pause, go on
//
// Thread-safety: Run once, from one thread. Ownership: borrows engine and
// metrics; owns its threads. Blocking: Run, until all of this is over; after
// stop at most drain_timeout plus a rollout's reaction to being cancelled.
// Errors: refused by the dispatcher (build, CPU class, certificate), an order
// that does not fit, an unusable address or folder; UNAVAILABLE: no learner.
class Actor {
 public:
  struct Options {
    std::string dispatcher_address;
    rpc::Security security;
    // Folder for fetched assets, made if need be, and its bound.
    std::string cache_folder;
    int64_t cache_bytes = int64_t{4} << 30;
    // Worker threads, >= 1.
    int threads = 1;
    // What registration says; see dispatch.proto.
    std::string name;
    std::string build;
    std::string mujoco_version;
    std::string cpu_class;
    // Bound of segments without verdict.
    int64_t outbox_bytes = int64_t{64} << 20;
    // For the end: to finish orders and send segments.
    absl::Duration drain_timeout = absl::Seconds(20);
    absl::Duration connect_timeout = absl::Seconds(20);
    // How long a learner may be away, also at the start.
    absl::Duration reconnect_timeout = absl::Minutes(2);
    rpc::BackoffOptions backoff;
  };

  // INVALID_ARGUMENT: a field out of range.
  static absl::StatusOr<std::unique_ptr<Actor>> Create(Options options,
                                                       Engine& engine,
                                                       ActorMetrics& metrics);
  ~Actor();

  // OK: stopped or drained.
  absl::Status Run(const StopToken& stop) SINEW_EXCLUDES(mu_);

 private:
  // What a worker did beside its last order's rollout, seconds.
  struct Spent {
    double idle = 0, blocked = 0, encode = 0;
  };

  Actor(Options options, Engine& engine, ActorMetrics& metrics);

  // actor.cc: the control plane.
  absl::Status Serve(const StopToken& stop) SINEW_EXCLUDES(mu_);
  absl::Status GaveUp(const absl::Status& last) const;
  absl::Status Connect(absl::Duration timeout, const StopToken& stop)
      SINEW_EXCLUDES(mu_);
  // Makes it the connection and starts it; returns how many orders to ask for.
  int Adopt(std::shared_ptr<Connection> connection) SINEW_EXCLUDES(mu_);
  absl::Status UsePeers(const v1::DispatcherMessage::Welcome& welcome,
                        const StopToken& stop);
  // Until stop, drain or a fatal error (OK), or the stream's end (why).
  absl::Status Attend(const StopToken& stop) SINEW_EXCLUDES(mu_);
  void Disconnect() SINEW_EXCLUDES(mu_);
  void TakeOrder(v1::Order order) SINEW_EXCLUDES(mu_);
  // Ends the work within `patience`.
  void Finish(bool hand_back, absl::Duration patience) SINEW_EXCLUDES(mu_);
  absl::Status fatal() const SINEW_EXCLUDES(mu_);
  std::shared_ptr<Connection> connection() const SINEW_EXCLUDES(mu_);

  // actor_worker.cc: the threads.
  void Work() SINEW_EXCLUDES(mu_);
  // Runs one order and hands its segment over, or gives it back.
  absl::Status RunOrder(const v1::Order& order, OrderRunner& runner,
                        Spent& spent) SINEW_EXCLUDES(mu_);
  OutgoingPtr MakeOutgoing(const v1::Order& order, OrderRunner::Result result,
                           Spent& spent);
  void ReportFailure(const v1::Order& order, const absl::Status& status)
      SINEW_EXCLUDES(mu_);
  void ReportVerdict(const OutgoingSegment& segment,
                     const v1::PutSegmentResponse& response)
      SINEW_EXCLUDES(mu_);
  void Return(const std::vector<int64_t>& order_ids, const std::string& reason,
              bool refused = false) SINEW_EXCLUDES(mu_);
  // Changes the number of orders that wait or run. Returns the connection
  // whose wants have to follow: a later one counts the change itself.
  std::shared_ptr<Connection> AddHeld(int change) SINEW_EXCLUDES(mu_);
  bool WaitForWorkers(CondVar::TimePoint deadline) SINEW_EXCLUDES(mu_);

  const Options options_;
  const int capacity_;
  Engine& engine_;
  ActorMetrics& metrics_;
  OrderInputs inputs_;
  AppliedVersions versions_;
  OrderQueue queue_;
  Outbox outbox_;
  // Running rollouts end with CANCELLED.
  std::atomic<bool> cancel_ = false;
  // Pauses of workers and fetches end.
  StopSource abandon_;

  mutable Mutex mu_;
  CondVar changed_;
  std::shared_ptr<Connection> connection_ SINEW_GUARDED_BY(mu_);
  absl::Status fatal_ SINEW_GUARDED_BY(mu_);
  bool drained_ SINEW_GUARDED_BY(mu_) = false;
  int held_ SINEW_GUARDED_BY(mu_) = 0;
  int working_ SINEW_GUARDED_BY(mu_) = 0;

  std::unique_ptr<ReplaySender> sender_;
  std::vector<std::jthread> workers_;
};

}  // namespace sinew::actor

#endif  // SINEW_ACTOR_SERVICE_ACTOR_H_
