#ifndef SINEW_COMMON_BUILD_INFO_H_
#define SINEW_COMMON_BUILD_INFO_H_

#include <string>

namespace sinew {

// Version of the release that this source belongs to (semantic versioning).
inline constexpr char kVersion[] = "0.1.0";

// Identity of this build: SHA-256 (hex) of the running program's own file.
// Two processes with one identity execute the same code; libraries loaded
// beside it are pinned by the workspace and report versions of their own.
// Computed on first use (about a millisecond per MB) and kept. Thread-safe.
// "unknown" where /proc is not mounted.
const std::string& BuildIdentity();

}  // namespace sinew

#endif  // SINEW_COMMON_BUILD_INFO_H_
