#ifndef SINEW_SIM_MOTION_FEATURES_H_
#define SINEW_SIM_MOTION_FEATURES_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "sim/motion/feature_file.h"
#include "sim/motion/library.h"

namespace sinew::motion {

// Motion features of Serifi et al. 2024 ("VMP"), equations (1) and (2):
//
//   m_t = {h, theta, v, q, dq, p}          M_t = {m_{t-W} .. m_{t+W}}
//
//   h      1      height of the root over the floor, m
//   theta  6      rotation of the root: columns 0 and 1 of its matrix,
//                 R00 R10 R20 R01 R11 R21
//   v      3 + 3  linear (m/s) and angular (rad/s) velocity of the root
//   q      J      joint positions, rad
//   dq     J      joint velocities, rad/s
//   p      3 E    end effectors less root, body by body, m
//
// theta, v and p of all frames of a window are those seen from the heading of
// the root in the window's centre: with Rz(a) the turn about z by a and yaw_i
// the heading of frame i (motion::Yaw), frame i is turned by Rz(-yaw_t). Where
// the root stands on the floor is left out on purpose.
//
// Normalised features are (m - mean) / deviation per feature, except theta,
// which stays. Mean and deviation are over all frames of the library, each seen
// from its own heading; a deviation below 1e-5 counts as 1. The window with
// W = 0 is the condition of a policy, so both share their units.
//
// Before its first frame and behind its last one a clip repeats that frame,
// velocities included; a looping clip goes on instead, cycle by cycle.

struct FeatureDefinition {
  // Bodies whose place is a feature, e.g. hands and feet; of the library's
  // bodies, all different, at least one.
  std::vector<std::string> end_effectors;
};

// The features of a library, computed once into a file beside it and mapped.
// What is stored is m_t from its own heading and that heading; a window is
// those rows, turned.
//
// Thread-safety: immutable. Ownership: borrows the library. Blocking: Open
// computes (about a second per hour of clips) or opens; Window may wait for a
// page of the disk; it neither allocates nor locks. Errors: INVALID_ARGUMENT
// naming an end effector that the library does not have, or that is named
// twice; those of the feature file.
class MotionFeatures {
 public:
  // `directory`: where "vmp.features.safetensors" is or goes, the library's.
  static absl::StatusOr<std::unique_ptr<const MotionFeatures>> Open(
      const Library& library, const FeatureDefinition& definition,
      const std::string& directory);

  // Features per frame: 13 + 2 J + 3 E.
  int width() const { return width_; }
  // [width] float32; of theta 0 and 1.
  absl::Span<const float> mean() const { return file_->tensor("mean"); }
  absl::Span<const float> deviation() const {
    return file_->tensor("deviation");
  }
  // The file itself, for whoever reports on it.
  const FeatureFile& file() const { return *file_; }

  // Writes [2 half + 1, width] float32, row-major, normalised: the window
  // around a stored frame. Preconditions: 0 <= frame < num_frames of the clip,
  // half >= 0 (paper: 30 at 60 Hz), out has that size.
  void Window(int clip, int64_t frame, int half, absl::Span<float> out) const;

 private:
  MotionFeatures(const Library& library, int width,
                 std::unique_ptr<const FeatureFile> file);
  void Row(int clip, int64_t frame, double centre_yaw, float* out) const;
  // Heading of any frame of the clip, as a number without jumps at cycles.
  double Heading(int clip, int64_t frame) const;

  const Library* library_;
  int width_;
  int joints_;
  std::unique_ptr<const FeatureFile> file_;
  absl::Span<const float> rows_;      // [N, width]
  absl::Span<const float> headings_;  // [N]
};

}  // namespace sinew::motion

#endif  // SINEW_SIM_MOTION_FEATURES_H_
