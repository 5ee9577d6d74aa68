#ifndef SINEW_SIM_WORLD_MIRROR_H_
#define SINEW_SIM_WORLD_MIRROR_H_

#include "absl/status/statusor.h"
#include "common/segment/mirror.h"
#include "sim/world/tracking_task.h"

namespace sinew::world {

// How a task's observation and action look to a body whose left and right have
// changed places: the world is mirrored in the vertical plane through the
// root's heading (y -> -y in the heading frame), joints and bodies change
// places by the character's mirror pairs. With S = diag(1, -1, 1):
//   vectors (positions, linear velocities)   S v
//   angular velocities                       -S w
//   rotations                                S R S
//   joints                                   sign * partner
// Bodies that the character names no partner for are their own.
//
// FAILED_PRECONDITION: a joint without partner (it may be its own), or one that
// differs from it in range, gains, torque limit, default position, action scale
// or drive (actuation.h), so that the mirrored body would be another one; or,
// where the observation has a block REFERENCE_BODIES or SELF_BODIES, two bodies
// whose frames at rest are not each other's mirror image; the message names it.
absl::StatusOr<SegmentMirror> MakeMirror(const TrackingTask& task);

}  // namespace sinew::world

#endif  // SINEW_SIM_WORLD_MIRROR_H_
