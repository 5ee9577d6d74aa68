#include "deploy/checkpoint/stable_bundle.h"

#include "absl/strings/str_cat.h"
#include "common/status_macros.h"
#include "deploy/checkpoint/client/validate_artifact.h"

namespace sinew::checkpoint {
namespace {

// Id of the bundle that an alias names; empty if it names nothing.
absl::StatusOr<std::string> BundleOf(ArtifactStore& store, const char* alias) {
  const absl::StatusOr<v1::Artifact> artifact = store.GetArtifact(alias);
  if (absl::IsNotFound(artifact.status())) return std::string();
  SINEW_RETURN_IF_ERROR(artifact.status());
  if (artifact->kind() == kBundleKind) return artifact->id();
  return absl::FailedPreconditionError(absl::StrCat(
      "alias \"", alias, "\": expected an artifact of kind \"", kBundleKind,
      "\", found ", artifact->id(), " of kind \"", artifact->kind(), "\""));
}

}  // namespace

absl::Status CheckArtifactId(const std::string& id) {
  SINEW_RETURN_IF_ERROR(ValidateName("artifact id", id));
  for (const char* alias : {kStable, kStablePrevious, kBest, kLatest}) {
    if (id != alias) continue;
    return absl::InvalidArgumentError(absl::StrCat(
        "artifact id: expected none that is the name of an alias, found \"", id,
        "\""));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::string> StableBundle(ArtifactStore& store) {
  return BundleOf(store, kStable);
}

absl::Status MoveStable(ArtifactStore& store, const std::string& id,
                        const std::string& incumbent) {
  if (id == incumbent) return absl::OkStatus();
  SINEW_ASSIGN_OR_RETURN(const std::string stable, StableBundle(store));
  if (stable != incumbent) {
    return absl::FailedPreconditionError(
        absl::StrCat("alias \"", kStable, "\": expected ",
                     incumbent.empty() ? "none" : incumbent, ", found ",
                     stable.empty() ? "none" : stable, ": it has moved"));
  }
  if (!incumbent.empty()) {
    SINEW_ASSIGN_OR_RETURN(const std::string before,
                           BundleOf(store, kStablePrevious));
    SINEW_RETURN_IF_ERROR(store.SetAlias(kStablePrevious, incumbent, before));
    absl::Status moved = store.SetAlias(kStable, id, incumbent);
    // The way back is what it was, as far as the store still answers.
    if (!moved.ok() && !before.empty()) {
      store.SetAlias(kStablePrevious, before, incumbent).IgnoreError();
    }
    return moved;
  }
  // Nothing to compare with: whoever came last has set it.
  SINEW_RETURN_IF_ERROR(store.SetAlias(kStable, id));
  SINEW_ASSIGN_OR_RETURN(const std::string now, StableBundle(store));
  if (now == id) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat("alias \"", kStable, "\": expected ", id, ", found ",
                   now.empty() ? "none" : now, ": it has moved"));
}

absl::StatusOr<std::string> RollBackStable(ArtifactStore& store) {
  SINEW_ASSIGN_OR_RETURN(const std::string stable, StableBundle(store));
  SINEW_ASSIGN_OR_RETURN(const std::string previous,
                         BundleOf(store, kStablePrevious));
  if (previous.empty() || previous == stable) {
    return absl::FailedPreconditionError(absl::StrCat(
        "alias \"", kStablePrevious,
        "\": expected another bundle than the stable one to go back to, found ",
        previous.empty() ? "none" : previous));
  }
  SINEW_RETURN_IF_ERROR(store.SetAlias(kStable, previous, stable));
  return previous;
}

}  // namespace sinew::checkpoint
