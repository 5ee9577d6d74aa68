#ifndef SINEW_TOOLS_ZOO_ZOO_ENTRY_H_
#define SINEW_TOOLS_ZOO_ZOO_ENTRY_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace sinew::zoo {

// What every folder of zoo/ must be:
//
//   zoo/NAME/bundle/   a bundle of at most kMostBundleBytes
//   zoo/NAME/CARD.md   its model card (model_card.h): names the digest of the
//                      bundle's manifest and every licence of its clips, and
//                      has every chapter and figures
//   zoo/NAME/eval.json what `sinew eval` says of this very bundle, its paths
//                      not absolute
//   zoo/NAME/samples.json  the same of `sinew sample`, where it has a prior
//   zoo/NAME/recipe.textproto  a recipe of the name that the bundle says
//
// and may hold:
//
//   zoo/NAME/fallen.json   as eval.json
//   zoo/NAME/state/        a compact state (tools/training/compact_state.h),
//                          recipe.textproto being its recipe to the byte
//
// Thread-safety: any thread. Ownership: none. Blocking: on the disk. Errors:
// name the folder or file, expected and found.

inline constexpr int64_t kMostBundleBytes = 8'000'000;

// Bytes of all files below a folder. NOT_FOUND: it is none.
absl::StatusOr<int64_t> FolderBytes(const std::string& folder);

// The bytes of a bundle. FAILED_PRECONDITION: more than kMostBundleBytes.
absl::StatusOr<int64_t> CheckBundleBytes(const std::string& bundle);

// Those of bundle::ReadBundle, CheckBundleBytes, ParseRecipe and
// tools::ReadCompactState; NOT_FOUND: a file that must be there is not;
// FAILED_PRECONDITION: the card or figures are of another bundle, the state is
// of another recipe, figures name an absolute path, the card lacks a chapter or
// figures, or a licence is unknown or not named in it.
absl::Status CheckZooEntry(const std::string& folder);

}  // namespace sinew::zoo

#endif  // SINEW_TOOLS_ZOO_ZOO_ENTRY_H_
