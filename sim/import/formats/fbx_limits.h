#ifndef SINEW_SIM_IMPORT_FORMATS_FBX_LIMITS_H_
#define SINEW_SIM_IMPORT_FORMATS_FBX_LIMITS_H_

#include <cstdint>

#include "absl/time/time.h"

namespace sinew::import {

// What reading an FBX file may cost (fbx.h).

// Larger files are refused.
inline constexpr int64_t kFbxMaxBytes = int64_t{256} << 20;
// Frames times joints, at most.
inline constexpr int64_t kFbxMaxRotations = 10'000'000;
// A file may take this long; a Mixamo clip takes some ten milliseconds.
inline constexpr absl::Duration kFbxPatience = absl::Seconds(60);
// Memory of the process: this, and so much a byte of the file.
inline constexpr int64_t kFbxMemory = int64_t{1} << 30;
inline constexpr int64_t kFbxMemoryPerByte = 24;

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_FBX_LIMITS_H_
