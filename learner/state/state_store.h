#ifndef SINEW_LEARNER_STATE_STATE_STORE_H_
#define SINEW_LEARNER_STATE_STATE_STORE_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "deploy/checkpoint/client/artifact_store.h"
#include "learner/trainer/trainer.h"

namespace sinew::learner {

// Training states in a store: artifacts "state-00000120" of kind "state" (the
// files: state_files.h), alias "latest".
//
// Thread-safety: as the store. Blocking: on the store. Errors: the store's; a
// failed save leaves all that was there.

// Stores a state, moves the alias, then drops the states beyond the newest
// `keep` (>= 1) whole ones. Where the store has no room, the oldest of them
// makes it, as long as one stays. If the id is taken by another state (a run
// that went on from an older one), "-2", "-3" ... is added.
absl::Status SaveState(checkpoint::ArtifactStore& store,
                       const Trainer::State& state, int keep);

// The newest whole state. Damaged ones are passed over and named in `warnings`
// (file, expected and found digest). NOT_FOUND: there is none; DATA_LOSS: all
// that are there are damaged. What says nothing about the state (the store is
// away) is returned at once.
absl::StatusOr<Trainer::State> LoadLatestState(
    checkpoint::ArtifactStore& store, std::vector<std::string>* warnings);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_STATE_STATE_STORE_H_
