#ifndef SINEW_SIM_IMPORT_FORMATS_BVH_H_
#define SINEW_SIM_IMPORT_FORMATS_BVH_H_

#include <cstdint>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "sim/import/formats/source_clip.h"

namespace sinew::import {

// BVH (Biovision hierarchy), in all the dialects that we have met: joints in
// any order, each with up to six channels of its own, one to three of them
// rotations in an order of its own; keywords in any case; any white space.
//
//   HIERARCHY
//   ROOT Hips { OFFSET x y z  CHANNELS 6 Xposition ... Zrotation ...
//     JOINT LeftUpLeg { OFFSET x y z  CHANNELS 3 ...  End Site { OFFSET ... } }
//   }
//   MOTION
//   Frames: 2
//   Frame Time: .0083333
//   one line per frame, one number per channel
//
// Rotations are degrees; channels "Z X Y" turn by Rz Rx Ry. A joint's position
// channels replace its offset, the root's are its place in the world. A clip
// has bones of fixed length: of positions that vary the median is the offset,
// with a warning if they vary by more than a centimetre. The end site of joint
// "Head" is the joint "Head_end". Joint names found twice get a number
// ("Hand_2"), with a warning. The format has neither unit nor up axis: both are
// concluded (file_frame.h) unless the user gives them. One frame is held.

// Larger input is refused.
inline constexpr int64_t kBvhMaxBytes = int64_t{1} << 30;

// Reads a clip. Total: any bytes give a clip or INVALID_ARGUMENT that names
// `source`, line, what was expected and what was found (RESOURCE_EXHAUSTED: too
// large). Memory is bounded by a small multiple of the input. `name` becomes
// the clip's.
//
// Thread-safety: pure function. Blocking: never.
absl::StatusOr<SourceClip> ParseBvh(absl::string_view bytes,
                                    absl::string_view name,
                                    absl::string_view source,
                                    const ReadOptions& options);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_BVH_H_
