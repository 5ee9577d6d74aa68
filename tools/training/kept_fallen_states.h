#ifndef SINEW_TOOLS_TRAINING_KEPT_FALLEN_STATES_H_
#define SINEW_TOOLS_TRAINING_KEPT_FALLEN_STATES_H_

#include <map>
#include <string>
#include <vector>

#include "common/blobs/blob_source.h"
#include "deploy/checkpoint/client/artifact_store.h"

namespace sinew::tools {

// The asset "fallen" that a run's store (kind "assets", run_store.h) keeps
// beside the same character, model and recipe as `assets` (bytes by role, these
// three among them): it is what would be made of them, after seconds of
// simulation. Null where there is none; `notes` says why where there are others
// or it cannot be read.
//
// Thread-safety: as the store. Ownership: the result is shared. Blocking: on
// the store. Errors: in `notes`.
Blob FindFallenStates(checkpoint::ArtifactStore& store,
                      const std::map<std::string, std::string>& assets,
                      std::vector<std::string>* notes);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_KEPT_FALLEN_STATES_H_
