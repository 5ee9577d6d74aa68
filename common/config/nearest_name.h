#ifndef SINEW_COMMON_CONFIG_NEAREST_NAME_H_
#define SINEW_COMMON_CONFIG_NEAREST_NAME_H_

#include <string>
#include <vector>

#include "absl/strings/string_view.h"

namespace sinew {

// The name that `typed` was probably meant to be: the one with the fewest
// insertions, deletions and replacements of letters, the first of equals;
// empty if `names` is. Pure.
std::string NearestName(absl::string_view typed,
                        const std::vector<std::string>& names);

}  // namespace sinew

#endif  // SINEW_COMMON_CONFIG_NEAREST_NAME_H_
