#ifndef SINEW_COMMON_WORKSPACE_FILES_H_
#define SINEW_COMMON_WORKSPACE_FILES_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace sinew {

// Files of this project that a program needs when it runs (characters, maps,
// helper programs), wherever it runs.
//
// Thread-safety: any thread. Blocking: looks at the disk. Errors: below.

// Folders that correspond to the root of the workspace, in the order in which
// to look: $RUNFILES_DIR/sinew (set where one program of ours starts another),
// the tests' runfiles, the binary's runfiles, the binary's folder, and the
// source tree found above the working directory.
std::vector<std::string> WorkspaceRoots();

// `path` is relative to the root of the workspace. NOT_FOUND lists where was
// looked.
absl::StatusOr<std::string> FindWorkspaceFile(absl::string_view path);

}  // namespace sinew

#endif  // SINEW_COMMON_WORKSPACE_FILES_H_
