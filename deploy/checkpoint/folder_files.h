#ifndef SINEW_DEPLOY_CHECKPOINT_FOLDER_FILES_H_
#define SINEW_DEPLOY_CHECKPOINT_FOLDER_FILES_H_

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "deploy/checkpoint/client/artifact_store.h"

namespace sinew::checkpoint {

// Folders as the files of an artifact. Thread-safe; they block on the disk;
// errors name the path.

// All regular files below a folder, by relative path. NOT_FOUND: no such
// folder. INVALID_ARGUMENT: it is empty, or something in it is neither file nor
// folder (a link, say).
absl::StatusOr<ArtifactFiles> ReadFolder(const std::string& folder);

// Makes `folder` of the files: written beside it, then renamed, so it is whole
// or not there. ALREADY_EXISTS: something of that name is there.
absl::Status WriteFolder(const ArtifactFiles& files, const std::string& folder);

}  // namespace sinew::checkpoint

#endif  // SINEW_DEPLOY_CHECKPOINT_FOLDER_FILES_H_
