#include "tools/sinew/resources.h"

#include <cstdlib>
#include <filesystem>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/config/recipe.h"
#include "common/files.h"
#include "common/status_context.h"
#include "common/status_macros.h"
#include "common/workspace_files.h"

namespace sinew::tools {
namespace {

constexpr char kRecipes[] = "deploy/recipes";

// Path of a recipe by name or path.
absl::StatusOr<std::string> FindRecipe(const std::string& name) {
  if (absl::StrContains(name, "/") || absl::EndsWith(name, ".textproto")) {
    if (FileExists(name)) return name;
    return absl::NotFoundError(absl::StrCat("recipe: no file ", name));
  }
  return FindWorkspaceFile(absl::StrCat(kRecipes, "/", name, ".textproto"));
}

}  // namespace

absl::StatusOr<std::string> OwnBinary() {
  std::error_code error;
  const auto binary = std::filesystem::read_symlink("/proc/self/exe", error);
  if (!error) return binary.string();
  return absl::NotFoundError(
      absl::StrCat("/proc/self/exe: cannot be read: ", error.message()));
}

absl::StatusOr<std::string> FindResource(const std::string& path) {
  std::vector<std::string> candidates;
  if (const auto binary = OwnBinary(); binary.ok()) {
    candidates.push_back(JoinPath(absl::StrCat(*binary, ".runfiles"), path));
  }
  if (const char* tests = std::getenv("TEST_SRCDIR"); tests != nullptr) {
    candidates.push_back(JoinPath(tests, path));
  }
  for (const std::string& candidate : candidates) {
    if (FileExists(candidate)) return candidate;
  }
  return absl::NotFoundError(absl::StrCat("no file ", path, "; looked for ",
                                          absl::StrJoin(candidates, ", ")));
}

absl::StatusOr<v1::Recipe> LoadRecipe(
    const std::string& name_or_path,
    const std::vector<std::string>& assignments) {
  SINEW_ASSIGN_OR_RETURN(const std::string path, FindRecipe(name_or_path));
  SINEW_ASSIGN_OR_RETURN(const std::string text,
                         ReadFile(path, /*max_bytes=*/1 << 20));
  SINEW_ASSIGN_OR_RETURN(v1::Recipe recipe, ParseRecipe(text, path));
  if (recipe.format_version() == 0) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": format_version: expected 1, found none"));
  }
  for (const std::string& assignment : assignments) {
    SINEW_RETURN_IF_ERROR(SetRecipeField(recipe, assignment));
  }
  recipe = WithDefaults(std::move(recipe));
  SINEW_RETURN_IF_ERROR(WithContext(ValidateRecipe(recipe), path));
  return recipe;
}

}  // namespace sinew::tools
