#ifndef SINEW_SIM_MOTION_LIBRARY_H_
#define SINEW_SIM_MOTION_LIBRARY_H_

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "common/mapped_file.h"
#include "common/policy/safetensors.h"
#include "proto/sinew/v1/motion.pb.h"

namespace sinew::motion {

// Frame tensors of a library, all float32, N rows in clip order; J joints,
// B bodies (all but the world, model order, body 0 of the list is the root),
// F feet. SI units, world frame (z up), quaternions wxyz with w >= 0 at the
// first frame of a clip and continuous after it.
//   root_position          [N, 3]
//   root_rotation          [N, 4]
//   root_linear_velocity   [N, 3]  world
//   root_angular_velocity  [N, 3]  world (not body-local as in qvel)
//   joint_position         [N, J]
//   joint_velocity         [N, J]
//   body_position          [N, B, 3]  body frame origins (xpos)
//   body_rotation          [N, B, 4]  xquat
//   body_linear_velocity   [N, B, 3]  of the frame origin, world
//   body_angular_velocity  [N, B, 3]  world
//   contact                [N, F]     1 where the foot bears on the floor
//   feedforward_torque     [N, J]     inverse dynamics minus fitted contact
//                                     forces, limited to the torque limit, Nm

// Pointers to one frame's rows, or to a caller's buffer with the same meaning.
struct FrameView {
  const float* root_position;
  const float* root_rotation;
  const float* root_linear_velocity;
  const float* root_angular_velocity;
  const float* joint_position;
  const float* joint_velocity;
  const float* body_position;
  const float* body_rotation;
  const float* body_linear_velocity;
  const float* body_angular_velocity;
  const float* contact;
  const float* feedforward_torque;
};

// Reference clips fitted to one character at one rate; immutable.
//
// Opening is not checking. Load reads the manifest and maps the frames: however
// long the library, it is open at once, and all processes that map it share
// one copy of its frames. What can be known without reading them is checked:
// version, names, sizes, shapes. Verify reads every byte; who trains on a
// library, evaluates with it or hands it to others calls it once, first:
//
//   Load -> Verify -> frame, frame, ...
//
// While a library is being written, Load gives the old one, the new one, or an
// error that says that manifest and frames do not belong together; where sizes
// are the same and only numbers differ, that error comes from Verify.
//
// Thread-safety: const methods from any thread. Ownership: owns its frames, or
// the mapping. Blocking: Load, Verify and Save on the disk; frame may wait for
// a page of it. Errors: INVALID_ARGUMENT naming file, clip and field; DATA_LOSS
// for frames that are not those of the manifest; NOT_FOUND; UNAVAILABLE if Load
// found another manifest at each of three attempts. Files must not be truncated
// under a process that has them mapped (common/mapped_file.h); Save
// replaces them instead.
class Library {
 public:
  // From a folder with manifest.json and frames.safetensors.
  static absl::StatusOr<std::unique_ptr<Library>> Load(
      const std::string& directory);
  // From the two files' bytes (assets over the wire), verified. `source` for
  // errors.
  static absl::StatusOr<std::unique_ptr<Library>> FromBytes(
      absl::string_view manifest_json, absl::string_view frames,
      absl::string_view source);
  // The same of frames that lie in a mapped file, not null, whose memory all
  // processes share that have it mapped.
  static absl::StatusOr<std::unique_ptr<Library>> FromMapped(
      absl::string_view manifest_json, std::shared_ptr<const MappedFile> frames,
      absl::string_view source);
  // Checks everything, then writes both files, the manifest last, each put in
  // its place when it is complete.
  static absl::Status Save(const v1::MotionLibrary& manifest,
                           const TensorMap& frames,
                           const std::string& directory);

  // Reads all frames: their SHA-256 is the manifest's, numbers are finite,
  // quaternions unit, contacts from 0 to 1.
  absl::Status Verify() const;

  const v1::MotionLibrary& manifest() const { return manifest_; }
  int num_clips() const { return manifest_.clips_size(); }
  const v1::ClipInfo& clip(int index) const { return manifest_.clips(index); }
  // -1 if absent.
  int FindClip(absl::string_view name) const;

  int num_joints() const { return manifest_.joints_size(); }
  int num_bodies() const { return manifest_.bodies_size(); }
  int num_feet() const { return manifest_.feet_size(); }

  // The stored row. Precondition: 0 <= frame < clip(clip).num_frames().
  FrameView frame(int clip, int64_t frame) const;
  // Elements of each of its tensors, in the order of FrameView.
  absl::Span<const int64_t> row_widths() const { return row_widths_; }

  // SHA-256 of manifest bytes and frames digest together.
  const std::string& digest() const { return digest_; }

 private:
  Library() = default;
  static absl::StatusOr<std::unique_ptr<Library>> OpenOnce(
      const std::string& manifest_json, const std::string& directory);
  // Sets manifest, source and digest.
  absl::Status ReadManifest(absl::string_view json, absl::string_view source);
  // Takes `frames`, which are those of mapped_ or copy_, without reading them.
  absl::Status Attach(absl::string_view frames);

  v1::MotionLibrary manifest_;
  std::string source_;  // for errors
  std::shared_ptr<const MappedFile> mapped_;
  std::string copy_;
  absl::string_view bytes_;                   // of one of the two
  std::map<std::string, TensorView> frames_;  // in bytes_
  FrameView base_{};
  std::vector<int64_t> row_widths_;  // by FrameColumns()
  std::string digest_;
};

// One reference frame after wrapping: rows of the library where they hold as
// they are, a buffer of its own for what is moved. Borrows the library.
// Allocate once per thread.
class ReferenceFrame {
 public:
  explicit ReferenceFrame(const Library& library);
  ReferenceFrame(const ReferenceFrame&) = delete;
  ReferenceFrame& operator=(const ReferenceFrame&) = delete;

  // Frame `frame` >= 0 of a clip. Looping clips: any frame, wrapped and moved
  // by the cycle transform (planar translation and yaw; velocities turned too).
  // Others: frames past the end repeat the last frame with zero velocities. No
  // allocation; the frame that was loaded last costs nothing.
  void Load(int clip, int64_t frame);

  // Of the last Load; points into the library too, and changes with each Load.
  const FrameView& view() const { return view_; }

 private:
  const Library* library_;
  std::vector<float> storage_;
  FrameView view_{};
  // What is loaded.
  int clip_ = -1;
  int64_t frame_ = -1;
};

// Last frame index at which an episode may stand: num_frames - 1 for clips
// that do not loop, a very large number for looping ones.
int64_t LastFrame(const v1::ClipInfo& clip);

}  // namespace sinew::motion

#endif  // SINEW_SIM_MOTION_LIBRARY_H_
