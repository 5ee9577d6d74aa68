#ifndef SINEW_TOOLS_TRAINING_RUN_STORE_H_
#define SINEW_TOOLS_TRAINING_RUN_STORE_H_

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/blobs/blob_source.h"
#include "common/clock.h"
#include "common/rpc/credentials.h"
#include "deploy/checkpoint/client/artifact_store.h"
#include "learner/trainer/trainer.h"
#include "proto/sinew/v1/run.pb.h"
#include "tools/training/task_setup.h"

namespace sinew::tools {

// Where a run keeps what must outlive it, in a folder or behind a checkpoint
// service, which serves one run:
//
//   kind "assets"   the task's assets, for actors to fetch
//   kind "state"    training states (learner/state); alias "latest"
//   kind "policy"   the best evaluated snapshot; alias "best"
//
// Thread-safety: any thread. Ownership: owns the store (and its connection);
// borrows the clock. Blocking: on disk or network. Errors: the store's.
class RunStore {
 public:
  // A snapshot's bytes and what its evaluation found.
  struct Policy {
    v1::EvaluatedPolicy evaluated;
    Blob snapshot;
  };

  // `where`: as checkpoint::OpenStore. No stop token: the last save comes after
  // stop.
  static absl::StatusOr<std::unique_ptr<RunStore>> Open(
      const std::string& where, const rpc::Security& security,
      const Clock& clock);

  checkpoint::ArtifactStore& artifacts() { return *store_; }

  absl::Status PutAssets(const TaskSetup& setup);
  // Roles of the assets that differ between `assets_sha256`, as PutAssets has
  // stored it, and `setup`.
  absl::StatusOr<std::vector<std::string>> ChangedAssets(
      const std::string& assets_sha256, const TaskSetup& setup);
  // The newest whole state; NOT_FOUND: there is none.
  absl::StatusOr<learner::Trainer::State> LoadState(
      std::vector<std::string>* warnings);

  absl::Status PutBest(const Policy& policy);
  // Unset: none yet.
  absl::StatusOr<std::optional<Policy>> GetBest();

 private:
  explicit RunStore(std::unique_ptr<checkpoint::ArtifactStore> store)
      : store_(std::move(store)) {}

  const std::unique_ptr<checkpoint::ArtifactStore> store_;
};

// Roles of the assets of `setup` that differ from `before`, digests by role.
// INTERNAL: its list does not parse.
absl::StatusOr<std::vector<std::string>> ChangedRoles(
    const std::map<std::string, std::string>& before, const TaskSetup& setup);

// Whether `a` is the better policy: more starts succeeded, then more frames
// survived, then less error.
bool IsBetter(const v1::EvaluatedPolicy& a, const v1::EvaluatedPolicy& b);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_RUN_STORE_H_
