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
#include "common/rpc/retry.h"

namespace sinew::teacher {

// The parts of one batch that are still to be answered, shared out to replicas:
//
//   workers, some per replica:  Take -> ask -> Done or Failed -> Take ...
//   whoever waits:              Await
//
// What becomes of a part that failed:
//   refused (INVALID_ARGUMENT) asked of others, never again of that replica: it
//                              is barred from that part
//   a wrong answer (DATA_LOSS) asked again; the third from one replica bars it
//                              from that part
//   away, late, full, a broken connection (INTERNAL, from gRPC)   asked again
//   anything else (another bundle, no permission)   asked again of others; the
//                              replica is out, and when all are, all ends
// Once every replica that is not out is barred from one part, all ends: with
// the refusal where each of them refused it, else as INTERNAL.
// The replica waits (back-off) before it takes anything again, and leaves the
// part to others as long as one of them has not failed since its last success.
//
// Thread-safety: any thread. Ownership: borrows the clock. Blocking: Take and
// Await, as long as `patience` after the latest success. Errors: Await's.
class PartQueue {
 public:
  struct Options {
    int64_t parts = 0;               // >= 1
    std::vector<std::string> peers;  // names of the replicas, >= 1
    rpc::BackoffOptions backoff = {};
    // Without any success for so long, all ends.
    absl::Duration patience = absl::Minutes(2);
  };

  PartQueue(const Options& options, Clock& clock);

  // The next part for a worker of this replica; none: all parts are answered,
  // or all has ended, or the replica is out.
  std::optional<int64_t> Take(int replica) SINEW_EXCLUDES(mu_);
  void Done(int replica) SINEW_EXCLUDES(mu_);
  void Failed(int replica, int64_t part, const absl::Status& status)
      SINEW_EXCLUDES(mu_);
  // All ends with this error, unless it has ended before: it is nobody's fault
  // that asking others would mend.
  void End(const absl::Status& status) SINEW_EXCLUDES(mu_);

  // OK once all parts are answered; else what ended it: CANCELLED (stop),
  // UNAVAILABLE or DEADLINE_EXCEEDED naming every replica with its last error,
  // End's, or one of the above.
  absl::Status Await(const std::stop_token& stop) SINEW_EXCLUDES(mu_);

 private:
  struct Part {
    int failed_by = -1;
    std::map<int, int> wrong_answers = {};  // by replica
    std::set<int> refused_by = {};
    absl::Status last_wrong_answer = absl::OkStatus();
    absl::Status last_refusal = absl::OkStatus();
  };
  struct Replica {
    rpc::Backoff backoff;
    Clock::TimePoint not_before;
    absl::Status last_error = absl::OkStatus();
    bool well = true;  // no failure since its last success
    bool out = false;
  };

  bool Ended() const SINEW_REQUIRES(mu_) {
    return remaining_ == 0 || !status_.ok();
  }
  // Index into waiting_, or -1.
  int Find(int replica) const SINEW_REQUIRES(mu_);
  bool IsBarred(int replica, const Part& part) const SINEW_REQUIRES(mu_);
  // Whether another one that may take the part is well.
  bool OtherIsWell(int replica, const Part& part) const SINEW_REQUIRES(mu_);
  // OK while some replica may take the part; else what all ends with.
  absl::Status Verdict(const Part& part) const SINEW_REQUIRES(mu_);
  // What a failure means for the whole; OK: go on.
  absl::Status Judge(int replica, Part& part, const absl::Status& status)
      SINEW_REQUIRES(mu_);
  absl::Status OutOfPatience() const SINEW_REQUIRES(mu_);

  const Options options_;
  Clock& clock_;

  Mutex mu_;
  CondVar changed_;
  std::vector<Replica> replicas_ SINEW_GUARDED_BY(mu_);
  std::vector<Part> parts_ SINEW_GUARDED_BY(mu_);
  std::deque<int64_t> waiting_ SINEW_GUARDED_BY(mu_);
  int64_t remaining_ SINEW_GUARDED_BY(mu_);
  Clock::TimePoint last_success_ SINEW_GUARDED_BY(mu_);
  absl::Status status_ SINEW_GUARDED_BY(mu_);
};

}  // namespace sinew::teacher

#endif  // SINEW_TEACHER_CLIENT_PART_QUEUE_H_
