#ifndef SINEW_LEARNER_DISPATCHER_DISPATCHER_H_
#define SINEW_LEARNER_DISPATCHER_DISPATCHER_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "common/clock.h"
#include "proto/sinew/v1/dispatch.grpc.pb.h"
#include "proto/sinew/v1/rollout.pb.h"

namespace sinew::learner {

// Hands work orders to actors: the server side of dispatch.proto.
//
// Example, one actor that may hold two orders:
//   actor:   register, want 2          -> welcome, order 0, order 1
//   learner: Add({2, 3})
//   actor:   done 0, want 1            -> order 2
//   actor:   (silent for 3 heartbeats) -> orders 1 and 2 wait again
//
// Thread-safety: all methods from any thread, Shutdown from one of the
//   program's own (not a gRPC handler). Ownership: a grpc::Service; must
//   outlive the server it is registered with. Call Shutdown before the
//   server's. Blocking: methods take one short lock; a thread of its own looks
//   at leases every quarter heartbeat. Errors: actors with another protocol
//   version, build, MuJoCo version or CPU class are refused with
//   FAILED_PRECONDITION that says what was expected and found; a message out
//   of turn ends its stream with INVALID_ARGUMENT.
class Dispatcher {
 public:
  struct Options {
    // heartbeat_seconds > 0 (CHECK).
    v1::DispatcherMessage::Welcome welcome;
    // What actors must present.
    std::string build;
    std::string mujoco_version;
    std::string cpu_class;
    absl::Duration reissue_after = absl::Seconds(20);
    // Told once per actor and version: seconds from the actor's hearing of a
    // snapshot to its acting with it. On gRPC's threads, no lock held.
    std::function<void(double seconds)> on_apply;
    // Borrowed; null: the machine's clocks.
    Clock* clock = nullptr;
  };

  // Totals for metrics and reports.
  struct Statistics {
    int64_t actors = 0;
    int64_t threads = 0;  // of all registered actors
    int64_t refused_actors = 0;
    int64_t lost_actors = 0;  // streams that ended holding orders
    int64_t orders_waiting = 0;
    int64_t orders_leased = 0;
    int64_t orders_reissued = 0;
    int64_t orders_returned = 0;
    int64_t applied_version = -1;  // newest version an actor acted with
    double apply_seconds = 0;      // latest publish-to-apply time reported
    double idle_seconds = 0;       // summed over actors' threads
    double blocked_seconds = 0;
  };

  static std::unique_ptr<Dispatcher> Create(const Options& options);
  // As Shutdown without patience.
  virtual ~Dispatcher() = default;

  // Makes orders available; actors that asked get them at once.
  virtual void Add(const std::vector<v1::Order>& orders) = 0;
  // The learner has these segments.
  virtual void Retire(const std::vector<int64_t>& order_ids) = 0;
  // Orders whose segments replay has answered, as actors say, rising. What a
  // replay that is asked afterwards still misses of them went elsewhere or was
  // lost: nobody sends it again, unless it is added again.
  virtual std::vector<int64_t> Finished() const = 0;
  virtual Statistics statistics() const = 0;
  // FAILED_PRECONDITION: replay refused the segment of an order three times,
  // named with the last verdict. Stays so.
  virtual absl::Status failure() const = 0;
  // Sends [drain] to every actor; a stream ends once its actor holds nothing,
  // or at `deadline` (wall time) by cancellation. No actor is admitted
  // afterwards. Returns when all streams have ended, at most 5 s late.
  virtual void Shutdown(absl::Time deadline) = 0;

  // Ends every stream with UNAVAILABLE, as where the learner is restarted: an
  // actor comes back to whoever listens at the address then. No order is given
  // out and nobody admitted afterwards; Shutdown is still to be called, and
  // tells nobody to go.
  virtual void Interrupt() = 0;

  virtual grpc::Service* service() = 0;
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_DISPATCHER_DISPATCHER_H_
