#include "tools/sinew/resources.h"

#include <filesystem>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/config/recipe.h"
#include "common/files.h"
#include "common/status_macros.h"

namespace sinew::tools {
namespace {

constexpr char kRecipes[] = "deploy/recipes";

absl::StatusOr<std::string> FindRecipe(const std::string& name) {
  if (absl::StrContains(name, "/") || absl::EndsWith(name, ".textproto")) {
    if (FileExists(name)) return name;
    return absl::NotFoundError(absl::StrCat("recipe: no file ", name));
  }
  std::vector<std::string> folders;
  std::error_code error;
  const auto binary = std::filesystem::read_symlink("/proc/self/exe", error);
  if (!error) {
    folders.push_back(
        JoinPath(absl::StrCat(binary.string(), ".runfiles/sinew"), kRecipes));
  }
  folders.push_back(kRecipes);
  for (const std::string& folder : folders) {
    const std::string path =
        JoinPath(folder, absl::StrCat(name, ".textproto"));
    if (FileExists(path)) return path;
  }
  return absl::NotFoundError(absl::StrCat("recipe: no \"", name, "\" in ",
                                          absl::StrJoin(folders, ", ")));
}

}  // namespace

absl::StatusOr<v1::Recipe> LoadRecipe(
    const std::string& name_or_path,
    const std::vector<std::string>& assignments) {
  SINEW_ASSIGN_OR_RETURN(const std::string path, FindRecipe(name_or_path));
  SINEW_ASSIGN_OR_RETURN(const std::string text,
                         ReadFile(path, /*max_bytes=*/1 << 20));
  SINEW_ASSIGN_OR_RETURN(v1::Recipe recipe, ParseRecipe(text, path));
  for (const std::string& assignment : assignments) {
    SINEW_RETURN_IF_ERROR(SetRecipeField(recipe, assignment));
  }
  recipe = WithDefaults(std::move(recipe));
  SINEW_RETURN_IF_ERROR(ValidateRecipe(recipe));
  return recipe;
}

}  // namespace sinew::tools
