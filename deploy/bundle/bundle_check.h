#ifndef SINEW_DEPLOY_BUNDLE_BUNDLE_CHECK_H_
#define SINEW_DEPLOY_BUNDLE_BUNDLE_CHECK_H_

#include "absl/status/status.h"
#include "deploy/bundle/bundle.h"

namespace sinew::bundle {

// Whether the parts of a bundle fit each other: physics and task in range,
// joints (order, gains, limits), tracked bodies and digest as the character
// has them, widths as the observation layout gives them, graph "policy" with
// valid, finite weights and those widths, the graphs of a latent (CheckLatent).
// INVALID_ARGUMENT names the file (in the bundle's directory) and field,
// expected and found. Pure.
absl::Status CheckBundle(const Bundle& bundle);

}  // namespace sinew::bundle

#endif  // SINEW_DEPLOY_BUNDLE_BUNDLE_CHECK_H_
