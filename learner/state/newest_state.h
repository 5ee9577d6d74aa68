#ifndef SINEW_LEARNER_STATE_NEWEST_STATE_H_
#define SINEW_LEARNER_STATE_NEWEST_STATE_H_

#include <string>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "common/status_macros.h"
#include "deploy/checkpoint/client/artifact_store.h"
#include "proto/sinew/v1/checkpoint.pb.h"
#include "proto/sinew/v1/training_state.pb.h"

namespace sinew::learner {

// What of training states can be read without learning: no libtorch here.
//
// Thread-safety: as the store. Ownership: none kept. Blocking: on the store.
// Errors: NOT_FOUND: there is no state; DATA_LOSS: all that are there are
// damaged; what says nothing about a state (the store is away) is returned at
// once.

// Kind of the artifacts, and the file of a state that is v1::TrainingState.
inline constexpr char kStateKind[] = "state";
inline constexpr char kStateCounters[] = "state.pb";

// The bytes of such a file. DATA_LOSS: they are none.
absl::StatusOr<v1::TrainingState> ParseCounters(const std::string& bytes);

// Counters and curriculum of the newest state whose kStateCounters is whole;
// its other files are not looked at. Newer ones are named in `warnings`.
absl::StatusOr<v1::TrainingState> LoadLatestCounters(
    checkpoint::ArtifactStore& store, std::vector<std::string>* warnings);

// The newest state that `load` makes something of. Those that it finds damaged
// (DATA_LOSS, NOT_FOUND) are passed over and named in `warnings`.
template <typename State>
absl::StatusOr<State> LoadNewestState(
    checkpoint::ArtifactStore& store,
    absl::FunctionRef<absl::StatusOr<State>(const v1::Artifact&)> load,
    std::vector<std::string>* warnings) {
  SINEW_ASSIGN_OR_RETURN(const v1::ListArtifactsResponse list,
                         store.ListArtifacts(kStateKind));
  const size_t before = warnings->size();
  for (const std::string& damaged : list.damaged()) {
    warnings->push_back(
        absl::StrCat("passed over a damaged record: ", damaged));
  }
  for (const v1::Artifact& artifact : list.artifacts()) {
    absl::StatusOr<State> state = load(artifact);
    if (!absl::IsDataLoss(state.status()) &&
        !absl::IsNotFound(state.status())) {
      return state;
    }
    warnings->push_back(absl::StrCat("passed over ", artifact.id(), ": ",
                                     state.status().message()));
  }
  if (warnings->size() == before) {
    return absl::NotFoundError("no training state");
  }
  return absl::DataLossError(absl::StrCat(
      "expected a whole training state, found only damaged ones, the newest: ",
      warnings->back()));
}

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_STATE_NEWEST_STATE_H_
