#ifndef SINEW_DEPLOY_BUNDLE_REPLACEABLE_H_
#define SINEW_DEPLOY_BUNDLE_REPLACEABLE_H_

#include <string>

#include "absl/status/status.h"

namespace sinew::bundle {

// Whether WriteBundle may put a bundle in the place of `directory`, and use the
// folders beside it that it works in: nothing is there, or an empty folder, or
// a bundle and nothing else. What is in the way will be removed.
// FAILED_PRECONDITION names the folder and what it holds besides.
//
// Thread-safety: any thread. Blocking: on the disk.
absl::Status CheckReplaceable(const std::string& directory);

}  // namespace sinew::bundle

#endif  // SINEW_DEPLOY_BUNDLE_REPLACEABLE_H_
