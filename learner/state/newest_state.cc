#include "learner/state/newest_state.h"

namespace sinew::learner {
namespace {

absl::StatusOr<v1::TrainingState> LoadCounters(checkpoint::ArtifactStore& store,
                                               const v1::Artifact& artifact) {
  for (const v1::Artifact::File& file : artifact.files()) {
    if (file.path() != kStateCounters) continue;
    SINEW_ASSIGN_OR_RETURN(const Blob bytes, store.GetBlob(file.sha256()));
    return ParseCounters(*bytes);
  }
  return absl::DataLossError(absl::StrCat("training state: expected a file ",
                                          kStateCounters, ", found none"));
}

}  // namespace

absl::StatusOr<v1::TrainingState> ParseCounters(const std::string& bytes) {
  v1::TrainingState state;
  if (state.ParseFromString(bytes)) return state;
  return absl::DataLossError(
      absl::StrCat(kStateCounters, ": expected a training state, found ",
                   bytes.size(), " bytes that are none"));
}

absl::StatusOr<v1::TrainingState> LoadLatestCounters(
    checkpoint::ArtifactStore& store, std::vector<std::string>* warnings) {
  return LoadNewestState<v1::TrainingState>(
      store,
      [&](const v1::Artifact& artifact) {
        return LoadCounters(store, artifact);
      },
      warnings);
}

}  // namespace sinew::learner
