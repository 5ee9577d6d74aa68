#ifndef SINEW_SIM_IMPORT_FORMATS_ASF_AMC_H_
#define SINEW_SIM_IMPORT_FORMATS_ASF_AMC_H_

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "sim/import/formats/source_clip.h"

namespace sinew::import {

// Acclaim's pair of formats: a skeleton (ASF) and motions of it (AMC).
//
// A bone lies in `direction` from the end of its parent and has a local frame
// C, given by `axis`, in which its angles are measured: with M the rotation by
// the angles of its `dof`, first one first, the bone turns against its parent
// by C M C^-1. Bones become joints at their starts, named after them, with an
// end joint "<bone>_end" after each last one, so that the identity is the ASF's
// pose as everywhere (source_clip.h).
//
// Lengths: CMU's files are in inches over the `length` of `:units`, so a unit
// is 0.0254 m / length, if a person's size comes out (file_frame.h). Neither
// file says which way is up; an AMC without ":SAMPLES-PER-SECOND" has 120
// frames per second, as CMU's have.
//
// Thread-safety: pure functions. Blocking: AsfCandidates on the disk.

// One angle of a bone, or one coordinate of the root.
struct AsfChannel {
  bool is_position = false;
  int axis = 0;  // 0, 1, 2: x, y, z
};

// What an AMC says of one bone (or the root, first), and what that means.
struct AsfBone {
  std::string name;
  int joint = 0;                     // in AsfSkeleton::skeleton
  Eigen::Quaterniond axis;           // C
  std::vector<AsfChannel> channels;  // empty: the bone never turns
};

// A skeleton in the file's axes and units.
struct AsfSkeleton {
  SourceSkeleton skeleton;
  std::vector<AsfBone> bones;  // [0] is the root; names differ
  Eigen::Vector3d root_position = Eigen::Vector3d::Zero();
  // `length` of :units; unset: not there.
  std::optional<double> length;
  bool angles_in_degrees = true;
};

// Larger input is refused.
inline constexpr int64_t kAsfMaxBytes = int64_t{16} << 20;
inline constexpr int64_t kAmcMaxBytes = int64_t{1} << 30;
// Frames per second of an AMC that does not say.
inline constexpr double kAmcFramesPerSecond = 120;

// Reads a skeleton. Total: any bytes give a skeleton or INVALID_ARGUMENT that
// names `source`, line, expected and found (RESOURCE_EXHAUSTED: too large).
absl::StatusOr<AsfSkeleton> ParseAsf(absl::string_view bytes,
                                     absl::string_view source);

// Reads a motion of a skeleton; errors as above, also if its bones are not the
// skeleton's. Memory is bounded by a small multiple of the input.
absl::StatusOr<SourceClip> ParseAmc(absl::string_view bytes,
                                    const AsfSkeleton& asf,
                                    absl::string_view name,
                                    absl::string_view source,
                                    const ReadOptions& options);

// Files beside an AMC that may be its skeleton, likeliest first: for
// "dir/02_01.amc" dir/02_01.asf, dir/02.asf, any .asf whose name begins the
// AMC's, then a single .asf of the folder. Empty: none, or no such folder.
std::vector<std::string> AsfCandidates(const std::string& amc_path);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_ASF_AMC_H_
