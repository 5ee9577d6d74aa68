#include "sim/character/character_path.h"

#include <cstdlib>
#include <filesystem>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "absl/strings/string_view.h"
#include "common/files.h"
#include "common/workspace_files.h"

namespace sinew::character {
namespace {

constexpr char kModels[] = "sim/character/models";

std::vector<std::string> EnvironmentFolders() {
  const char* folders = std::getenv("SINEW_CHARACTERS");
  return absl::StrSplit(folders == nullptr ? "" : folders, ':',
                        absl::SkipEmpty());
}

std::string FolderOf(const std::string& path) {
  return std::filesystem::path(path).parent_path().string();
}

std::vector<std::string> SearchFolders() {
  std::vector<std::string> folders = EnvironmentFolders();
  for (const std::string& root : WorkspaceRoots()) {
    folders.push_back(JoinPath(root, kModels));
  }
  return folders;
}

}  // namespace

absl::StatusOr<std::string> FindCharacter(const std::string& name_or_path) {
  if (absl::StrContains(name_or_path, "/")) {
    if (FileExists(name_or_path)) return name_or_path;
    return absl::NotFoundError(
        absl::StrCat("character: no file ", name_or_path));
  }
  const std::vector<std::string> folders = SearchFolders();
  for (const std::string& folder : folders) {
    const std::string path =
        JoinPath(JoinPath(folder, name_or_path), "character.textproto");
    if (FileExists(path)) return path;
  }
  return absl::NotFoundError(absl::StrCat(
      "character: no \"", name_or_path, "\", looked for ", name_or_path,
      "/character.textproto in ", absl::StrJoin(folders, ", ")));
}

absl::StatusOr<std::string> FindModelFile(const std::string& character_path,
                                          const std::string& model_file) {
  std::vector<std::string> tried;
  if (absl::StartsWith(model_file, "@")) {
    const std::string in_runfiles =
        absl::StrReplaceAll(model_file.substr(1), {{"//", "/"}});
    tried.push_back(JoinPath(FolderOf(character_path), in_runfiles));
    for (const std::string& folder : EnvironmentFolders()) {
      tried.push_back(JoinPath(folder, in_runfiles));
    }
    for (const std::string& root : WorkspaceRoots()) {
      // Other repositories lie below external/ and beside the workspace.
      tried.push_back(JoinPath(JoinPath(root, "external"), in_runfiles));
      tried.push_back(JoinPath(JoinPath(root, ".."), in_runfiles));
    }
  } else {
    tried.push_back(JoinPath(FolderOf(character_path), model_file));
  }
  for (const std::string& path : tried) {
    if (FileExists(path)) return path;
  }
  return absl::NotFoundError(
      absl::StrCat("character ", character_path, ": model_file ", model_file,
                   " not found, looked for ", absl::StrJoin(tried, ", ")));
}

}  // namespace sinew::character
