#include "sim/character/character_path.h"

#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <utility>
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

// The path, if a file is there.
absl::StatusOr<std::string> CheckPath(const std::string& path) {
  constexpr char kExpected[] =
      "character: expected a name (as \"humanoid\") or a .textproto file, "
      "found ";
  if (!FileExists(path)) {
    return absl::NotFoundError(absl::StrCat(kExpected, "no file ", path));
  }
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    return absl::InvalidArgumentError(
        absl::StrCat(kExpected, "the folder ", path));
  }
  return path;
}

}  // namespace

absl::StatusOr<std::string> FindCharacter(const std::string& name_or_path) {
  if (absl::StrContains(name_or_path, "/") ||
      absl::EndsWith(name_or_path, ".textproto")) {
    return CheckPath(name_or_path);
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

std::string LocalModelFile(const std::string& model_file) {
  if (absl::StartsWith(model_file, "$")) return model_file.substr(1);
  if (!absl::StartsWith(model_file, "@")) return model_file;
  return absl::StrReplaceAll(model_file.substr(1), {{"//", "/"}});
}

absl::StatusOr<std::string> FindModelFile(const std::string& character_path,
                                          const std::string& model_file) {
  const std::string local = LocalModelFile(model_file);
  std::vector<std::string> tried = {JoinPath(FolderOf(character_path), local)};
  if (absl::StartsWith(model_file, "@")) {
    for (const std::string& folder : EnvironmentFolders()) {
      tried.push_back(JoinPath(folder, local));
    }
    for (const std::string& root : WorkspaceRoots()) {
      // Other repositories lie below external/ and beside the workspace.
      tried.push_back(JoinPath(JoinPath(root, "external"), local));
      tried.push_back(JoinPath(JoinPath(root, ".."), local));
    }
  } else if (absl::StartsWith(model_file, "$")) {
    const std::pair<std::string, std::string> parts =
        absl::StrSplit(model_file.substr(1), absl::MaxSplits('/', 1));
    const char* folder = std::getenv(parts.first.c_str());
    tried.push_back(folder == nullptr
                        ? absl::StrCat("$", parts.first, ", which is not set")
                        : JoinPath(folder, parts.second));
  }
  for (const std::string& path : tried) {
    if (FileExists(path)) return path;
  }
  return absl::NotFoundError(
      absl::StrCat("character ", character_path, ": model_file ", model_file,
                   " not found, looked for ", absl::StrJoin(tried, ", ")));
}

}  // namespace sinew::character
