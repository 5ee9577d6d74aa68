#ifndef SINEW_DEPLOY_CHECKPOINT_STABLE_BUNDLE_H_
#define SINEW_DEPLOY_CHECKPOINT_STABLE_BUNDLE_H_

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "deploy/checkpoint/client/artifact_store.h"

namespace sinew::checkpoint {

// The bundle that others use, by the alias `stable`, and the one that it was
// before, by `stable-previous`. Both aliases keep their bundles from being
// collected.
//
//   incumbent = StableBundle(store);
//   ... compare ...
//   MoveStable(store, "bundle-2", incumbent);   // unless it moved meanwhile
//   RollBackStable(store);                      // incumbent again
//
// Thread-safety, blocking: as the store's. Errors: the store's; they name
// alias and artifact, expected and found.
inline constexpr char kStable[] = "stable";
inline constexpr char kStablePrevious[] = "stable-previous";
inline constexpr char kBundleKind[] = "bundle";

// Whether an artifact may have that id: INVALID_ARGUMENT if it is no id, or a
// name that a store's aliases have (stable, stable-previous, best, latest),
// which it would stand in for.
absl::Status CheckArtifactId(const std::string& id);

// Id of the stable bundle; empty if there is none. FAILED_PRECONDITION: the
// alias names an artifact of another kind.
absl::StatusOr<std::string> StableBundle(ArtifactStore& store);

// Makes `id` the stable bundle, and `incumbent` (empty: none) the previous one.
// FAILED_PRECONDITION: `incumbent` is no longer the stable one, which then
// stays what it is; the previous one is then what whoever moved it has made it.
// After any other error the previous one is what it was, as far as the store
// still answers. Nothing changes if `id` is the incumbent. Without
// an incumbent there is nothing that the store could compare: of two first
// promotions at a time the last one holds, and the other one is refused if it
// sees that. A kill between the two steps leaves the incumbent stable, and
// named by both aliases: which bundle was the previous one is lost.
absl::Status MoveStable(ArtifactStore& store, const std::string& id,
                        const std::string& incumbent);

// Makes the previous bundle the stable one again and returns its id.
// FAILED_PRECONDITION: there is none, or it is the stable one already (so a
// second call does not bring back what the first one took away).
absl::StatusOr<std::string> RollBackStable(ArtifactStore& store);

}  // namespace sinew::checkpoint

#endif  // SINEW_DEPLOY_CHECKPOINT_STABLE_BUNDLE_H_
