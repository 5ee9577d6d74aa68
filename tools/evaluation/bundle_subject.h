#ifndef SINEW_TOOLS_EVALUATION_BUNDLE_SUBJECT_H_
#define SINEW_TOOLS_EVALUATION_BUNDLE_SUBJECT_H_

#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "proto/sinew/v1/bundle.pb.h"
#include "tools/evaluation/subject.h"

namespace sinew::evaluation {

struct BundleSubject {
  Subject subject;
  v1::BundleManifest manifest;
};

// A bundle's policy on a library's clips, with so many fallen states
// (MakeFallenStates); 0: none. A start fails beyond that mean distance of the
// bodies, m; unset: the bundle's own. Blocks on the disk. Errors: those of
// ReadBundle and Library::Load; INVALID_ARGUMENT naming the library, the field,
// expected and found, if the clips are of another character or rate.
absl::StatusOr<BundleSubject> LoadBundleSubject(
    const std::string& bundle, const std::string& motions,
    int fallen_starts = 0,
    std::optional<double> max_mean_body_distance = std::nullopt);

}  // namespace sinew::evaluation

#endif  // SINEW_TOOLS_EVALUATION_BUNDLE_SUBJECT_H_
