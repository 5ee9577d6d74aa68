#ifndef SINEW_TOOLS_SINEW_RESOURCES_H_
#define SINEW_TOOLS_SINEW_RESOURCES_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew::tools {

// Path of the running program.
absl::StatusOr<std::string> OwnBinary();

// A file of another repository that the build put beside the binary,
// "REPOSITORY/PATH": in the runfiles of the binary or of the test that runs it.
// (This project's own: common/workspace_files.h.) NOT_FOUND lists where was
// looked.
absl::StatusOr<std::string> FindResource(const std::string& path);

// A recipe by name (deploy/recipes/NAME.textproto, wherever
// common/workspace_files.h finds it) or by path, with `--set` assignments
// applied, defaults filled, checked. INVALID_ARGUMENT, NOT_FOUND (lists where
// was looked).
absl::StatusOr<v1::Recipe> LoadRecipe(
    const std::string& name_or_path,
    const std::vector<std::string>& assignments);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_RESOURCES_H_
