#ifndef SINEW_LEARNER_STATE_STATE_SAVER_H_
#define SINEW_LEARNER_STATE_STATE_SAVER_H_

#include <cstdint>
#include <optional>
#include <stop_token>
#include <thread>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "common/clock.h"
#include "common/mutex.h"
#include "deploy/checkpoint/client/artifact_store.h"
#include "learner/state/save_metrics.h"
#include "learner/trainer/trainer.h"

namespace sinew::learner {

// Saves training states beside training: Trainer::Save copies the state, the
// rest (serialise, digest, write) happens on a thread of this object's own.
//
//   if (due && saver.Start(trainer.Save())) ...
//   if (auto result = saver.TakeResult()) ...   // report, count
//   saver.Flush(absl::Minutes(1))               // before the program ends
//
// A failed save is reported and counted; what was saved before stays, and
// training goes on.
//
// Thread-safety: any thread. Ownership: borrows store, clock and metrics; owns
// the thread. Blocking: Flush; the destructor, for the save in flight, which
// the store's own deadlines bound. Errors: in results.
class StateSaver {
 public:
  struct Result {
    absl::Status status;
    int64_t iteration = 0;
    double seconds = 0;
    // Of weights, snapshots and counters.
    int64_t bytes = 0;
  };

  // Keeps the newest `keep` (>= 1) states.
  StateSaver(checkpoint::ArtifactStore& store, int keep, Clock& clock,
             SaveMetrics& metrics);
  ~StateSaver() = default;
  StateSaver(const StateSaver&) = delete;
  StateSaver& operator=(const StateSaver&) = delete;

  // Begins to save. False, and nothing happens, while another save is in
  // flight: the caller tries again after its next iteration.
  bool Start(Trainer::State state) SINEW_EXCLUDES(mu_);

  bool idle() const SINEW_EXCLUDES(mu_);

  // The latest save that has ended since the last call.
  std::optional<Result> TakeResult() SINEW_EXCLUDES(mu_);

  // Waits until no save is in flight. DEADLINE_EXCEEDED: it still is.
  absl::Status Flush(absl::Duration timeout, const std::stop_token& stop = {})
      SINEW_EXCLUDES(mu_);

 private:
  void Run(const std::stop_token& stop) SINEW_EXCLUDES(mu_);
  Result Save(const Trainer::State& state);

  checkpoint::ArtifactStore& store_;
  const int keep_;
  Clock& clock_;
  SaveMetrics& metrics_;

  mutable Mutex mu_;
  CondVar changed_;
  // In flight.
  std::optional<Trainer::State> state_ SINEW_GUARDED_BY(mu_);
  std::optional<Result> result_ SINEW_GUARDED_BY(mu_);

  // Last: it uses all of the above. Ends once nothing is in flight.
  std::jthread thread_;
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_STATE_STATE_SAVER_H_
