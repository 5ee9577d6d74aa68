#ifndef SINEW_COMMON_FINITE_H_
#define SINEW_COMMON_FINITE_H_

#include "absl/strings/string_view.h"

namespace sinew {

// True if no IEEE number in `bytes` (little-endian, any alignment; an
// incomplete last number is ignored) is infinite or NaN. Pure, vectorised: runs
// at memory speed, since it sees every byte that peers send.
bool AllFinite32(absl::string_view bytes);
bool AllFinite64(absl::string_view bytes);

}  // namespace sinew

#endif  // SINEW_COMMON_FINITE_H_
