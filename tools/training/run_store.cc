#include "tools/training/run_store.h"

#include <cstdint>
#include <utility>

#include "common/status_macros.h"
#include "learner/state/state_files.h"

namespace sinew::tools {

RunStore::RunStore(std::string folder)
    : folder_(std::move(folder)), assets_(int64_t{1} << 36) {}

absl::Status RunStore::PutAssets(const TaskSetup& setup) {
  for (const Blob& blob : setup.blobs) {
    SINEW_RETURN_IF_ERROR(assets_.Put(*blob).status());
  }
  return absl::OkStatus();
}

absl::StatusOr<Blob> RunStore::GetBlob(const std::string& sha256) {
  return assets_.GetBlob(sha256);
}

absl::Status RunStore::SaveState(const learner::Trainer::State& state,
                                 int keep) {
  return learner::SaveState(folder_, state, keep);
}

absl::StatusOr<learner::Trainer::State> RunStore::LoadState(
    std::vector<std::string>* warnings) {
  return learner::LoadLatestState(folder_, warnings);
}

}  // namespace sinew::tools
