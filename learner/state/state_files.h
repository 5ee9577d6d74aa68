#ifndef SINEW_LEARNER_STATE_STATE_FILES_H_
#define SINEW_LEARNER_STATE_STATE_FILES_H_

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "learner/trainer/trainer.h"

namespace sinew::learner {

// Training states in a folder, one sub-folder each:
//
//   state-00000120/state.pb             v1::TrainingState
//   state-00000120/tensors.safetensors  weights, moments, normaliser
//   state-00000120/snapshot-N           bytes of the snapshots it names
//   state-00000120/DIGESTS              "sha256  file" lines, written last
//
// A folder without DIGESTS, or whose files do not match it, is no state: a kill
// at any point leaves the states that were there before. A state that is there
// is never written over.
//
// Thread-safety: one caller per folder. Blocking: on the disk.

// Writes a state and then removes the oldest beyond `keep` (>= 1) whole ones,
// and broken ones older than it. RESOURCE_EXHAUSTED when the disk is full: what
// was there stays.
absl::Status SaveState(const std::string& folder, const Trainer::State& state,
                       int keep);

// The newest whole state. NOT_FOUND if there is none; broken ones are passed
// over and named in `warnings` (file, expected and found digest).
absl::StatusOr<Trainer::State> LoadLatestState(
    const std::string& folder, std::vector<std::string>* warnings);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_STATE_STATE_FILES_H_
