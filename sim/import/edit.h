#ifndef SINEW_SIM_IMPORT_EDIT_H_
#define SINEW_SIM_IMPORT_EDIT_H_

#include <limits>
#include <vector>

#include "absl/status/statusor.h"
#include "common/segment/mirror.h"
#include "sim/character/character.h"
#include "sim/import/retarget/dynamics.h"
#include "sim/import/retarget/model_motion.h"

namespace sinew::import {

// Cleaning of motions that are already on a character. All are pure functions:
// the motion that comes in stays what it is. ApplyEdits (apply_edits.h) is how
// an importer uses them.
//
// An edited clip keeps its `trial` (motion.proto); a mirrored one names the
// clip that it mirrors in `mirror_of`.
//
// Thread-safety: pure; a Dynamics is scratch of one thread. Blocking: Edit and
// FindLoop milliseconds to a second per minute of motion. Errors:
// INVALID_ARGUMENT, expected and found.

// Frames from `from_s` to `to_s` seconds of the motion, both included, rounded
// to whole frames; `to_s` beyond the end means the end. What is cut out of a
// looping motion does not loop, unless nothing is cut off. Error: less than two
// frames are left.
absl::StatusOr<ModelMotion> Trim(const ModelMotion& motion, double from_s,
                                 double to_s);

// The motion moved over the floor and turned about the vertical so that its
// first frame's root stands at x = y = 0 and has heading 0, looking along +x.
// Heights stay.
ModelMotion AlignHeading(const ModelMotion& motion);

// What of a qpos changes places when left and right do.
struct MotionMirror {
  std::vector<int> addresses;  // of the joints in qpos, action order
  RowMirror joints;
};

// FAILED_PRECONDITION naming the joint that the character names no partner for.
absl::StatusOr<MotionMirror> MakeMotionMirror(
    const character::Character& character);

// The motion as a mirror in the plane y = 0 shows it. With S = diag(1, -1, 1):
// root position S p, root rotation S R S, joints sign * partner, a cycle's y
// and yaw negative. The root's frame must be symmetric at rest, as that of
// every character is (skeleton maps ask for it). Twice is the identity.
ModelMotion Mirror(const MotionMirror& mirror, const ModelMotion& motion);

// Whether each foot bears in each frame, [frames][feet]: a point of it is low
// and slow while the floor carries the body (ground.h).
std::vector<std::vector<bool>> FootContacts(Dynamics* dynamics,
                                            const ModelMotion& motion);

struct LoopOptions {
  // Bounds of the period, seconds.
  double least_s = 0.5;
  double most_s = 10;
};

// Frames [first, last): frame `last` repeats frame `first`, moved over the
// floor.
struct Loop {
  int first = 0, last = 0;
  // How badly, sqrt of:
  //   mean over joints of (q' - q)^2 + (kLoopTime (dq' - dq))^2, rad^2
  //   + angle between the roots' rotations less their headings, squared
  //   + (kLoopPerMetre * difference of root heights)^2
  //   + (kLoopPerMetre kLoopTime * difference of root velocities, each seen
  //      from its heading)^2
  //   + kLoopContact^2 per foot that bears in one and not in the other
  double cost = 0;
};
inline constexpr double kLoopTime = 0.1;     // s: velocity to position
inline constexpr double kLoopPerMetre = 3;   // rad / m
inline constexpr double kLoopContact = 0.5;  // rad
// A loop that costs more is none: no pair of frames is alike.
inline constexpr double kLoopMostCost = 0.6;

// The pair of frames with the least cost, the longer period where two are
// equal. NOT_FOUND naming the least cost if that is above kLoopMostCost, or if
// the motion is shorter than the least period.
absl::StatusOr<Loop> FindLoop(Dynamics* dynamics, const ModelMotion& motion,
                              const LoopOptions& options);

// The looping motion of a loop's frames. What of the cycle is a turn of less
// than kLeastCycleYaw counts as drift. The difference that remains between
// frame `last`, moved back by the cycle, and frame `first` is spread evenly
// over all frames, half of it to either end, so that frame n continues frame 0
// without a jump.
ModelMotion CloseLoop(const ModelMotion& motion, const Loop& loop);

// Longer gaps, s, are not led over but made up.
inline constexpr double kMostBlendGap = 2;

// INVALID_ARGUMENT: not in (0, kMostBlendGap].
absl::Status CheckBlendGap(double gap_s);

// `gap_s` in frames, whole ones and at least one.
int BlendSteps(double gap_s, double rate);

// `first`, then BlendSteps that lead over, then `second`, which is
// placed so that it goes on with the heading and at the place to which the mean
// of both velocities leads. Between the last frame of the one and the first of
// the other every coordinate follows a cubic with their values and velocities
// (rotation: in the tangent space of the first), so positions are continuous
// and velocities too. Where a foot would go below the floor in between the root
// is lifted, smoothly. A looping motion counts as its stored frames; the result
// does not loop. blend_clips.h makes a clip of it. Errors: different rates or
// models; CheckBlendGap.
absl::StatusOr<ModelMotion> Blend(Dynamics* dynamics, const ModelMotion& first,
                                  const ModelMotion& second, double gap_s);

// What to do with a motion; the default is nothing.
struct EditOptions {
  // Trim.
  double from_s = 0;
  double to_s = std::numeric_limits<double>::infinity();
  // FindLoop and CloseLoop, if it does not loop already.
  bool loop = false;
  LoopOptions loop_options;
  bool mirror = false;
  bool align_heading = false;
};

// Trim, loop, mirror, in this order (ApplyEdits aligns).
absl::StatusOr<ModelMotion> Edit(Dynamics* dynamics, const MotionMirror& mirror,
                                 const ModelMotion& motion,
                                 const EditOptions& options);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_EDIT_H_
