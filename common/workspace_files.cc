#include "common/workspace_files.h"

#include <cstdlib>
#include <filesystem>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/files.h"

namespace sinew {

std::vector<std::string> WorkspaceRoots() {
  std::vector<std::string> roots;
  if (const char* runfiles = std::getenv("RUNFILES_DIR")) {
    roots.push_back(JoinPath(runfiles, "sinew"));
  }
  if (const char* runfiles = std::getenv("TEST_SRCDIR")) {
    const char* workspace = std::getenv("TEST_WORKSPACE");
    roots.push_back(JoinPath(runfiles, workspace ? workspace : "sinew"));
  }
  std::error_code error;
  const auto binary = std::filesystem::read_symlink("/proc/self/exe", error);
  if (!error) {
    roots.push_back(absl::StrCat(binary.string(), ".runfiles/sinew"));
    // A binary copied next to its data.
    roots.push_back(binary.parent_path().string());
  }
  auto folder = std::filesystem::current_path(error);
  for (; !error && folder.has_relative_path(); folder = folder.parent_path()) {
    if (std::filesystem::exists(folder / "WORKSPACE")) {
      roots.push_back(folder.string());
      break;
    }
  }
  return roots;
}

absl::StatusOr<std::string> FindWorkspaceFile(absl::string_view path) {
  const std::vector<std::string> roots = WorkspaceRoots();
  for (const std::string& root : roots) {
    const std::string candidate = JoinPath(root, path);
    if (FileExists(candidate)) return candidate;
  }
  return absl::NotFoundError(absl::StrCat("no file ", path, ", looked in ",
                                          absl::StrJoin(roots, ", ")));
}

}  // namespace sinew
