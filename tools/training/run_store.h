#ifndef SINEW_TOOLS_TRAINING_RUN_STORE_H_
#define SINEW_TOOLS_TRAINING_RUN_STORE_H_

#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/blobs/blob_ring.h"
#include "common/blobs/blob_source.h"
#include "learner/trainer/trainer.h"
#include "tools/training/task_setup.h"

namespace sinew::tools {

// Where a run keeps what must outlive it: assets, training states.
//
// Thread-safety: GetBlob from any thread, the rest from one. Ownership: owns
// the assets' bytes. Blocking: on the disk. Errors: those of the disk.
class RunStore : public BlobSource {
 public:
  explicit RunStore(std::string folder);

  absl::Status PutAssets(const TaskSetup& setup);
  absl::StatusOr<Blob> GetBlob(const std::string& sha256) override;

  // Keeps the newest `keep` states.
  absl::Status SaveState(const learner::Trainer::State& state, int keep);
  // The newest whole state; NOT_FOUND: there is none.
  absl::StatusOr<learner::Trainer::State> LoadState(
      std::vector<std::string>* warnings);

 private:
  const std::string folder_;
  BlobRing assets_;
};

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_RUN_STORE_H_
