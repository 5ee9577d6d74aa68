#ifndef SINEW_REPLAY_RUN_CLAIM_H_
#define SINEW_REPLAY_RUN_CLAIM_H_

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "common/clock.h"

namespace sinew::replay {

// Which run a table serves, and whether another one may have it. A run is
// active while its learner's Take calls come or wait, and for kActive after the
// last one, unless it says that it ends. Its own learner may come anew at any
// time, after a kill too.
//
//   Begin("a") Touch ... 20 s ... Begin("b")  refused: 40 s are left
//                        ... 20 s ... Begin("a")  a's next learner
//                        ... 60 s ... Begin("b")  a is dropped
//
// Thread-safety: none; the table guards it. Ownership: borrows the clock.
// Blocking: never. Errors: as said.
class RunClaim {
 public:
  static constexpr absl::Duration kActive = absl::Seconds(60);

  explicit RunClaim(const Clock& clock) : clock_(clock) {}

  // A learner starts a run anew; logs which one goes for it.
  // FAILED_PRECONDITION: another run is active; names both, and for how long.
  absl::Status Begin(const std::string& run_id);
  // A Take call of the run waits or is done.
  void Touch() { active_ = clock_.SteadyNow(); }
  // The run takes nothing more for now.
  void End() { active_.reset(); }

  // Empty: none yet.
  const std::string& run_id() const { return run_id_; }

 private:
  const Clock& clock_;
  std::string run_id_;
  std::optional<Clock::TimePoint> active_;
};

}  // namespace sinew::replay

#endif  // SINEW_REPLAY_RUN_CLAIM_H_
