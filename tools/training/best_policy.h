#ifndef SINEW_TOOLS_TRAINING_BEST_POLICY_H_
#define SINEW_TOOLS_TRAINING_BEST_POLICY_H_

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "common/blobs/blob_source.h"
#include "learner/trainer/trainer.h"
#include "tools/training/run_store.h"

namespace sinew::tools {

// Keeps the best evaluated snapshot in the store. An evaluation says how good a
// snapshot was some iterations ago, so the latest few are remembered.
//
//   Load                      what earlier sessions found
//   Remember, Observe         after each iteration
//
// Thread-safety: one caller. Ownership: borrows the store; shares snapshots'
// bytes. Blocking: Load, and Observe where something better was found. Errors:
// the store's; it may be tried again with the next evaluation.
class BestPolicy {
 public:
  // `assets_sha256` of the run: what was found of others does not count.
  BestPolicy(RunStore& store, std::string assets_sha256)
      : store_(store), assets_sha256_(std::move(assets_sha256)) {}

  // `assets_before`: of the run's newest state, or empty. A best policy that
  // does not say which assets it is of is of these.
  absl::Status Load(const std::string& assets_before);

  // The snapshot made after `iteration`, and where training stood then.
  void Remember(int64_t iteration, Blob snapshot, int64_t samples,
                double train_seconds);
  // Stores the snapshot that the report's evaluation is about, if it is the
  // best so far.
  absl::Status Observe(const learner::IterationReport& report);

  const std::optional<RunStore::Policy>& best() const { return best_; }
  // Whether the store's best policy is of other assets.
  bool is_of_others() const { return is_of_others_; }

 private:
  RunStore& store_;
  const std::string assets_sha256_;
  std::optional<RunStore::Policy> best_;
  bool is_of_others_ = false;
  std::deque<RunStore::Policy> recent_;  // newest last
};

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_BEST_POLICY_H_
