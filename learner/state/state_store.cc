#include "learner/state/state_store.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/status_macros.h"
#include "learner/state/newest_state.h"
#include "learner/state/state_files.h"

namespace sinew::learner {
namespace {

using checkpoint::ArtifactFiles;
using checkpoint::ArtifactStore;

// More states of one iteration than this are no accident.
constexpr int kMaxSameIteration = 100;

// Stores the files under the first free name, which `record` then has.
absl::Status PutUnderFreeName(ArtifactStore& store, const ArtifactFiles& files,
                              v1::Artifact& record) {
  const std::string name = absl::StrFormat("state-%08d", record.iteration());
  absl::Status status;
  for (int i = 1; i <= kMaxSameIteration; ++i) {
    record.set_id(i == 1 ? name : absl::StrCat(name, "-", i));
    status = PutFiles(store, record, files);
    if (!absl::IsAlreadyExists(status)) break;
  }
  return status;
}

absl::StatusOr<Trainer::State> LoadState(ArtifactStore& store,
                                         const std::string& id) {
  SINEW_ASSIGN_OR_RETURN(const ArtifactFiles files, GetFiles(store, id));
  return StateFromFiles(files);
}

}  // namespace

absl::Status SaveState(ArtifactStore& store, const Trainer::State& state,
                       int keep) {
  const ArtifactFiles files = StateToFiles(state);
  v1::Artifact record;
  record.set_kind(kStateKind);
  record.set_iteration(state.counters.iteration());
  absl::Status status = PutUnderFreeName(store, files, record);
  if (absl::IsResourceExhausted(status) && keep > 1) {
    SINEW_RETURN_IF_ERROR(store.Retain(kStateKind, keep - 1));
    status = PutUnderFreeName(store, files, record);
  }
  SINEW_RETURN_IF_ERROR(status);
  SINEW_RETURN_IF_ERROR(store.SetAlias(checkpoint::kLatest, record.id()));
  return store.Retain(kStateKind, keep);
}

absl::StatusOr<Trainer::State> LoadLatestState(
    ArtifactStore& store, std::vector<std::string>* warnings) {
  return LoadNewestState<Trainer::State>(
      store,
      [&](const v1::Artifact& artifact) {
        return LoadState(store, artifact.id());
      },
      warnings);
}

}  // namespace sinew::learner
