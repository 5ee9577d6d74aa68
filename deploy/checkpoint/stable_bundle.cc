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

// From a stable bundle to another one, with a way back.
absl::Status MoveFrom(ArtifactStore& store, const std::string& id,
                      const std::string& incumbent) {
  // What cannot be read is no way back.
  const std::string before = BundleOf(store, kStablePrevious).value_or("");
  SINEW_RETURN_IF_ERROR(store.SetAlias(kStablePrevious, incumbent, before));
  absl::Status moved = store.SetAlias(kStable, id, incumbent);
  if (moved.ok() || before.empty()) return moved;
  // The way back is what it was, unless whoever overtook this call, or this
  // call itself, has moved on from the incumbent: then that is the way back.
  const absl::StatusOr<std::string> now = BundleOf(store, kStable);
  if (now.ok() && (*now == incumbent || *now == before)) {
    store.SetAlias(kStablePrevious, before, incumbent).IgnoreError();
  }
  return moved;
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
    return MoveFrom(store, id, incumbent);
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
