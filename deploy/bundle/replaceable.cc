#include "deploy/bundle/replaceable.h"

#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/strings/strip.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "deploy/bundle/manifest.h"

namespace sinew::bundle {
namespace {

bool IsOfABundle(absl::string_view name) {
  return name == kManifestFile || name == kGraphFile || name == kWeightsFile ||
         name == kCharacterFolder || absl::EndsWith(name, ".onnx") ||
         IsTemporaryName(name);
}

absl::Status Foreign(const std::string& folder, absl::string_view found) {
  return absl::FailedPreconditionError(
      absl::StrCat(folder, ": expected a bundle, an empty folder or none, ",
                   "found one that holds ", found, "; give another folder"));
}

// A bundle, or, where it may be `unfinished`, what there is of one.
absl::Status CheckHoldsABundle(const std::string& folder, bool unfinished) {
  if (!FileExists(folder)) return absl::OkStatus();
  SINEW_ASSIGN_OR_RETURN(const std::vector<std::string> names,
                         ListDirectory(folder));
  for (const std::string& name : names) {
    if (!IsOfABundle(name)) return Foreign(folder, name);
  }
  if (unfinished || names.empty()) return absl::OkStatus();
  const auto manifest = ReadFile(JoinPath(folder, kManifestFile));
  if (manifest.ok() && absl::StrContains(*manifest, "\"format_version\"")) {
    return absl::OkStatus();
  }
  return Foreign(folder, absl::StrCat("no ", kManifestFile, " of a bundle but ",
                                      names.front()));
}

}  // namespace

absl::Status CheckReplaceable(const std::string& directory) {
  const std::string target(absl::StripSuffix(directory, "/"));
  SINEW_RETURN_IF_ERROR(CheckHoldsABundle(target, /*unfinished=*/false));
  SINEW_RETURN_IF_ERROR(CheckHoldsABundle(absl::StrCat(target, ".part"),
                                          /*unfinished=*/true));
  // Where the file system cannot exchange two folders
  // (common/replace_directory.h).
  return CheckHoldsABundle(absl::StrCat(target, ".old"), /*unfinished=*/false);
}

}  // namespace sinew::bundle
