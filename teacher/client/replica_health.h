#ifndef SINEW_TEACHER_CLIENT_REPLICA_HEALTH_H_
#define SINEW_TEACHER_CLIENT_REPLICA_HEALTH_H_

#include <optional>
#include <stop_token>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "common/clock.h"
#include "common/mutex.h"
#include "common/rpc/retry.h"

namespace sinew::teacher {

// What is known of a teacher's replicas for longer than a batch. One is
//
//   present  it may be given rows, once its back-off is over
//   away     a call of its failed, or was late; or it has not come yet
//
//   present --Failed--> away --Introduced--> present
//
// A full queue (RESOURCE_EXHAUSTED) and a wrong answer (DATA_LOSS) are answers:
// after them a replica is what it was, and waits. Waits become longer until it
// has answered rows: one that only introduces itself is asked ever less.
//
// Thread-safety: any thread. Ownership: borrows the clock. Blocking: AwaitTurn,
// until its stop token; others never. Errors: none.
class ReplicaHealth {
 public:
  struct Options {
    int replicas = 0;  // >= 1; all away at the beginning
    rpc::BackoffOptions backoff = {};
    // A part is late once it has been out for so many times as long as whoever
    // would take it over needs for one, >= 1, and for the floor, > 0.
    double late_factor = 4;
    absl::Duration late_floor = absl::Seconds(1);
  };

  ReplicaHealth(const Options& options, Clock& clock);

  // From when on it may be given rows; none: it has to be introduced first.
  std::optional<Clock::TimePoint> ReadyFrom(int replica) const
      SINEW_EXCLUDES(mu_);
  // Present, and without a failure since it last answered.
  bool IsWell(int replica) const SINEW_EXCLUDES(mu_);
  // How long another one may have had a part before this one takes it over.
  absl::Duration LateAfter(int replica) const SINEW_EXCLUDES(mu_);
  // Since it last answered rows; OK: none.
  absl::Status LastError(int replica) const SINEW_EXCLUDES(mu_);

  // It has answered a part, `took` after it was asked.
  void Answered(int replica, absl::Duration took) SINEW_EXCLUDES(mu_);
  // A call or an introduction of its failed; or others have taken over what it
  // has had for too long.
  void Failed(int replica, const absl::Status& status) SINEW_EXCLUDES(mu_);
  // It was found to be the teacher.
  void Introduced(int replica) SINEW_EXCLUDES(mu_);

  // Waits until a replica has to be introduced and its back-off is over. False
  // once stop is requested.
  bool AwaitTurn(int replica, const std::stop_token& stop) SINEW_EXCLUDES(mu_);

 private:
  struct Replica {
    rpc::Backoff backoff;
    Clock::TimePoint not_before;
    bool present = false;
    bool failed = false;  // since it last answered
    absl::Status last_error = absl::OkStatus();
    absl::Duration usual = absl::ZeroDuration();  // of a part; 0: none so far
  };

  const Options options_;
  Clock& clock_;

  mutable Mutex mu_;
  CondVar changed_;
  std::vector<Replica> replicas_ SINEW_GUARDED_BY(mu_);
};

}  // namespace sinew::teacher

#endif  // SINEW_TEACHER_CLIENT_REPLICA_HEALTH_H_
