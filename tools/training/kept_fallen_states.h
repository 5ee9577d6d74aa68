#ifndef SINEW_TOOLS_TRAINING_KEPT_FALLEN_STATES_H_
#define SINEW_TOOLS_TRAINING_KEPT_FALLEN_STATES_H_

#include <map>
#include <string>
#include <vector>

#include "common/blobs/blob_source.h"
#include "common/clock.h"
#include "common/rpc/credentials.h"
#include "common/stop.h"
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

// Where a run keeps its assets: a checkpoint service, or else a folder.
struct FallenStatesPlace {
  std::string address = {};  // empty: the folder
  std::string folder = {};   // there or not
  rpc::Security security = {};
};

// The same of a store that is opened for it; null without a note if there is no
// such folder.
Blob FindFallenStatesAt(const FallenStatesPlace& place, const Clock& clock,
                        const StopToken& stop,
                        const std::map<std::string, std::string>& assets,
                        std::vector<std::string>* notes);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_KEPT_FALLEN_STATES_H_
