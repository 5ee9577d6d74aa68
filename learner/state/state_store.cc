#include "learner/state/state_store.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/status_macros.h"
#include "learner/state/state_files.h"

namespace sinew::learner {
namespace {

using checkpoint::ArtifactFiles;
using checkpoint::ArtifactStore;

constexpr char kKind[] = "state";
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

// True for failures of one state that an older one may not have.
bool IsDamage(const absl::Status& status) {
  return absl::IsDataLoss(status) || absl::IsNotFound(status);
}

absl::StatusOr<Trainer::State> LoadState(ArtifactStore& store,
                                         const std::string& id) {
  SINEW_ASSIGN_OR_RETURN(const ArtifactFiles files, GetFiles(store, id));
  return StateFromFiles(files);
}

}  // namespace

absl::Status SaveState(ArtifactStore& store, const Trainer::State& state,
                       int keep, bool is_best) {
  const ArtifactFiles files = StateToFiles(state);
  v1::Artifact record;
  record.set_kind(kKind);
  record.set_iteration(state.counters.iteration());
  absl::Status status = PutUnderFreeName(store, files, record);
  if (absl::IsResourceExhausted(status) && keep > 1) {
    SINEW_RETURN_IF_ERROR(store.Retain(kKind, keep - 1));
    status = PutUnderFreeName(store, files, record);
  }
  SINEW_RETURN_IF_ERROR(status);
  SINEW_RETURN_IF_ERROR(store.SetAlias("latest", record.id()));
  if (is_best) SINEW_RETURN_IF_ERROR(store.SetAlias("best", record.id()));
  return store.Retain(kKind, keep);
}

absl::StatusOr<Trainer::State> LoadLatestState(
    ArtifactStore& store, std::vector<std::string>* warnings) {
  SINEW_ASSIGN_OR_RETURN(const v1::ListArtifactsResponse list,
                         store.ListArtifacts(kKind));
  for (const std::string& damaged : list.damaged()) {
    warnings->push_back(
        absl::StrCat("passed over a damaged record: ", damaged));
  }
  for (const v1::Artifact& artifact : list.artifacts()) {
    absl::StatusOr<Trainer::State> state = LoadState(store, artifact.id());
    if (state.ok() || !IsDamage(state.status())) return state;
    warnings->push_back(absl::StrCat("passed over ", artifact.id(), ": ",
                                     state.status().message()));
  }
  if (warnings->empty()) return absl::NotFoundError("no training state");
  return absl::DataLossError(absl::StrCat(
      "expected a whole training state, found only damaged ones, the newest: ",
      warnings->back()));
}

}  // namespace sinew::learner
