#ifndef SINEW_TEACHER_CLIENT_PART_QUEUE_H_
#define SINEW_TEACHER_CLIENT_PART_QUEUE_H_

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "common/clock.h"
#include "common/mutex.h"
#include "teacher/client/replica_health.h"

namespace sinew::teacher {

// The parts of one batch that are still to be answered, shared out to replicas:
//
//   workers, some per replica:  Take -> ask -> Done or Failed -> Take ...
//   whoever introduces:         Introduced
//   whoever waits:              Await
//
// What becomes of a part that failed:
//   refused (INVALID_ARGUMENT) asked of others, never again of that replica: it
//                              is barred from that part
//   a wrong answer (DATA_LOSS) asked again; the third from one replica bars it
//                              from that part
//   away, late, full, a broken connection (INTERNAL, from gRPC)   asked again
//   anything else (another bundle, no permission)   asked again of others; the
//                              replica is out, and when all are, all ends; so
//                              it is after an introduction that failed so, or
//                              was refused
// Once every replica that is not out is barred from one part, all ends: with
// the refusal where each of them refused it, else as INTERNAL.
// The replica waits (back-off; and until it is introduced again, unless it was
// full or wrong: replica_health.h) before it takes anything again, and leaves
// the part to others as long as one of them is well.
//
// A part that is late at one replica is taken by another one that has nothing
// else to do (ReplicaHealth::LateAfter); the first answer counts, and whoever
// was late gets nothing more before it is introduced again.
//
// Thread-safety: any thread. Ownership: borrows health and clock. Blocking:
// Take and Await, as long as `patience` after the latest success. Errors:
// Await's.
class PartQueue {
 public:
  struct Options {
    int64_t parts = 0;               // >= 1
    std::vector<std::string> peers;  // names of the replicas, >= 1
    // Without any success for so long, all ends.
    absl::Duration patience = absl::Minutes(2);
  };

  PartQueue(const Options& options, ReplicaHealth& health, Clock& clock);

  // The next part for a worker of this replica; none: all parts are answered,
  // or all has ended, or the replica is out.
  std::optional<int64_t> Take(int replica) SINEW_EXCLUDES(mu_);
  // A good answer to a part that it took. True: the first one, which the caller
  // puts into its place; false: somebody else has.
  bool Done(int replica, int64_t part) SINEW_EXCLUDES(mu_);
  void Failed(int replica, int64_t part, const absl::Status& status)
      SINEW_EXCLUDES(mu_);
  // What came of introducing a replica, which `health` knows already.
  void Introduced(int replica, const absl::Status& status) SINEW_EXCLUDES(mu_);
  // All ends with this error, unless it has ended before: it is nobody's fault
  // that asking others would mend.
  void End(const absl::Status& status) SINEW_EXCLUDES(mu_);

  // OK once all parts are answered; else what ended it: CANCELLED (stop),
  // UNAVAILABLE or DEADLINE_EXCEEDED naming every replica with its last error,
  // End's, or one of the above.
  absl::Status Await(const std::stop_token& stop) SINEW_EXCLUDES(mu_);

 private:
  struct Holder {
    int replica;
    Clock::TimePoint since;
  };
  struct Part {
    bool done = false;
    std::vector<Holder> holders = {};  // who has been asked; none: it waits
    int failed_by = -1;
    std::map<int, int> wrong_answers = {};  // by replica
    std::set<int> refused_by = {};
    absl::Status last_wrong_answer = absl::OkStatus();
    absl::Status last_refusal = absl::OkStatus();
  };

  bool Ended() const SINEW_REQUIRES(mu_) {
    return remaining_ == 0 || !status_.ok();
  }
  // A part that waits and that the replica may take, or -1.
  int64_t TakeWaiting(int replica) SINEW_REQUIRES(mu_);
  // A part that others have had for too long, or -1; `wake` becomes no later
  // than the moment at which there may be one.
  int64_t TakeLate(int replica, Clock::TimePoint& wake) SINEW_REQUIRES(mu_);
  void MarkLate(const Holder& holder) SINEW_REQUIRES(mu_);
  // How long the replica has had it, which it has no more.
  absl::Duration Release(int replica, Part& part) SINEW_REQUIRES(mu_);
  bool IsBarred(int replica, const Part& part) const SINEW_REQUIRES(mu_);
  // Whether another one that may take the part is well.
  bool OtherIsWell(int replica, const Part& part) const SINEW_REQUIRES(mu_);
  // OK while some replica may take the part; else what all ends with.
  absl::Status Verdict(const Part& part) const SINEW_REQUIRES(mu_);
  // Marks what a failure means for the part; whether the replica is out.
  bool Judge(int replica, Part& part, const absl::Status& status)
      SINEW_REQUIRES(mu_);
  // Marks that it is out; what all ends with, or OK.
  absl::Status PutOut(int replica, const absl::Status& status)
      SINEW_REQUIRES(mu_);
  // The verdict on everything that waits.
  absl::Status VerdictOnAll() const SINEW_REQUIRES(mu_);
  absl::Status OutOfPatience() const SINEW_REQUIRES(mu_);

  const Options options_;
  ReplicaHealth& health_;
  Clock& clock_;

  Mutex mu_;
  CondVar changed_;
  std::vector<bool> out_ SINEW_GUARDED_BY(mu_);  // by replica
  std::vector<Part> parts_ SINEW_GUARDED_BY(mu_);
  std::deque<int64_t> waiting_ SINEW_GUARDED_BY(mu_);
  int64_t remaining_ SINEW_GUARDED_BY(mu_);
  Clock::TimePoint last_success_ SINEW_GUARDED_BY(mu_);
  absl::Status status_ SINEW_GUARDED_BY(mu_);
};

}  // namespace sinew::teacher

#endif  // SINEW_TEACHER_CLIENT_PART_QUEUE_H_
