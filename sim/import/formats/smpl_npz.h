#ifndef SINEW_SIM_IMPORT_FORMATS_SMPL_NPZ_H_
#define SINEW_SIM_IMPORT_FORMATS_SMPL_NPZ_H_

#include <cstdint>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "sim/import/formats/source_clip.h"

namespace sinew::import {

// Motions of SMPL, SMPL-H and SMPL-X bodies as NumPy's npz, the way that AMASS
// (amass.is.tue.mpg.de) and what follows it publish them. T frames:
//   poses or pose_aa     (T, 66 | 72 | 156 | 165): rotation vectors (rad) of
//                        the joints relative to their parents, pelvis first;
//                        also (T, 22 | 24 | 52 | 55, 3); or, as in AMASS-X,
//   root_orient (T, 3) and pose_body (T, 63 | 69)
//   trans or transl      (T, 3): moves the model's origin, m
//   mocap_framerate, mocap_frame_rate, fps or frame_rate: one number
//   betas, gender        optional: the body's shape
// float16 to float64 or integers, C or Fortran order; other members are not
// read. The first 22 joints are kept (smpl_skeleton.h, which says what stands
// in for the body model); hands' and faces' rotations are dropped.
//
// The world of the file has z up as in AMASS, and is kept; y up is concluded
// where the body stands along y in the mean, and turned.

// Larger files are refused.
inline constexpr int64_t kSmplMaxBytes = int64_t{1} << 30;

// Reads a clip. Total: any bytes give a clip or an error that names `source`,
// member, frame and column, expected and found. INVALID_ARGUMENT: the bytes;
// RESOURCE_EXHAUSTED: too large, or longer than kMaxClipSeconds (found before
// anything of that size is inflated). Options: metres_per_unit is that of
// trans; quaternion_order means nothing here.
absl::StatusOr<SourceClip> ParseSmplNpz(absl::string_view bytes,
                                        absl::string_view name,
                                        absl::string_view source,
                                        const ReadOptions& options);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_SMPL_NPZ_H_
