#ifndef SINEW_LEARNER_STATE_STATE_FILES_H_
#define SINEW_LEARNER_STATE_STATE_FILES_H_

#include "absl/status/statusor.h"
#include "deploy/checkpoint/client/artifact_store.h"
#include "learner/trainer/trainer.h"

namespace sinew::learner {

// A training state as the files of an artifact, and back:
//
//   state.pb             v1::TrainingState
//   tensors.safetensors  weights, moments, normaliser
//   snapshot-VERSION     bytes of each snapshot that state.pb names
//   memory-SHA256        chunks of a distillation's memory that it names
//
// Each file is a blob, so what two states share (most chunks) is stored once.
// Other files are left alone.
//
// Pure functions. StateFromFiles: DATA_LOSS naming the file that is missing,
// does not parse, holds numbers that are not finite, or has another digest
// than state.pb says.
checkpoint::ArtifactFiles StateToFiles(const Trainer::State& state);
absl::StatusOr<Trainer::State> StateFromFiles(
    const checkpoint::ArtifactFiles& files);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_STATE_STATE_FILES_H_
