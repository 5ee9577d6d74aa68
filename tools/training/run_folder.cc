#include "tools/training/run_folder.h"

#include <algorithm>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/config/message_differences.h"
#include "common/config/recipe.h"
#include "common/digest.h"
#include "common/status_macros.h"

namespace sinew::tools {

absl::StatusOr<std::unique_ptr<RunFolder>> RunFolder::Open(
    const std::string& path, const v1::Recipe& recipe) {
  SINEW_RETURN_IF_ERROR(MakeDirectories(path));
  SINEW_ASSIGN_OR_RETURN(std::unique_ptr<DirectoryLock> lock,
                         DirectoryLock::Acquire(path));
  std::unique_ptr<RunFolder> folder(new RunFolder(path, std::move(lock)));
  if (HasState(path)) {
    SINEW_RETURN_IF_ERROR(folder->CheckSameRecipe(recipe));
  }
  return folder;
}

absl::Status RunFolder::WriteConfig(const v1::Recipe& recipe,
                                    const std::string& trained_with) const {
  const std::string text = PrintRecipe(recipe);
  if (trained_with.empty() || trained_with == Sha256Hex(text)) {
    return WriteFileAtomically(config(), text);
  }
  // Which fields differ, if the folder knows.
  SINEW_RETURN_IF_ERROR(CheckSameRecipe(recipe));
  return absl::InvalidArgumentError(absl::StrCat(
      path_,
      ": expected the recipe of the training state that it goes on from "
      "(SHA-256 ",
      trained_with, "), found another one (", Sha256Hex(text),
      "); give the same one, or another place for the states"));
}

bool RunFolder::HasState(const std::string& path) {
  const auto names = ListDirectory(JoinPath(CheckpointsOf(path), "artifacts"));
  if (names.ok() &&
      std::any_of(names->begin(), names->end(), [](const std::string& name) {
        return absl::StartsWith(name, "state-");
      })) {
    return true;
  }
  const std::string stages = JoinPath(path, "stages");
  const auto folders = ListDirectory(stages);
  return folders.ok() &&
         std::any_of(folders->begin(), folders->end(),
                     [&](const std::string& folder) {
                       return HasState(JoinPath(stages, folder));
                     });
}

absl::Status RunFolder::CheckSameRecipe(const v1::Recipe& recipe) const {
  if (!FileExists(config())) return absl::OkStatus();
  SINEW_ASSIGN_OR_RETURN(const std::string text, ReadFile(config()));
  SINEW_ASSIGN_OR_RETURN(v1::Recipe before, ParseRecipe(text, config()));
  before = WithDefaults(std::move(before));
  const std::string differences = MessageDifferences(before, recipe);
  if (differences.empty()) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(path_,
                   ": expected the recipe that the run was started with, found "
                   "another one (",
                   differences, "); give the same one, or another --run"));
}

}  // namespace sinew::tools
