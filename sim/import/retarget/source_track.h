#ifndef SINEW_SIM_IMPORT_RETARGET_SOURCE_TRACK_H_
#define SINEW_SIM_IMPORT_RETARGET_SOURCE_TRACK_H_

#include <Eigen/Geometry>
#include <vector>

#include "sim/import/formats/source_clip.h"

namespace sinew::import {

// How a looping clip goes on: about world z through the root's place in the
// first frame, then along the floor (as v1::ClipInfo).
struct Cycle {
  double x = 0, y = 0;  // m
  double yaw = 0;       // rad

  // Where a place is one cycle later or, not `forward`, earlier. `pivot` is the
  // root's place in the first frame; its height does not matter.
  Eigen::Vector3d Move(const Eigen::Vector3d& place,
                       const Eigen::Vector3d& pivot, bool forward) const;
};

// The same motion of the world as a cycle about another point of the first
// frame.
Cycle MovePivot(const Cycle& cycle, const Eigen::Vector3d& from,
                const Eigen::Vector3d& to);

// A clip at a constant rate, its loop closed.
struct SourceTrack {
  double rate = 0;  // frames per second
  bool loops = false;
  Cycle cycle;
  // [frames]; a looping track's frame n is frame 0 moved by the cycle.
  std::vector<Eigen::Vector3d> root_position;
  // [frames][joints] parent-relative, continuous in sign.
  std::vector<std::vector<Eigen::Quaterniond>> rotation;
  // Speed of the track over the file's, from rounding to whole frames; 1: same.
  double retiming = 1;

  int frames() const { return static_cast<int>(root_position.size()); }
};

// Turns of less than this per cycle are taken for drift of the capture and
// spread over the clip like the rest of the seam; larger ones are meant.
inline constexpr double kLeastCycleYaw = 0.25;

// Resamples a clip to `rate` (motion::ResampleRotations). A looping clip's last
// key is taken as its first, moved over the floor; the difference that remains
// is spread evenly over the clip, half of it to either end.
SourceTrack MakeTrack(const SourceClip& clip, double rate);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_RETARGET_SOURCE_TRACK_H_
