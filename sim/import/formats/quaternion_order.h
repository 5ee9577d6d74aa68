#ifndef SINEW_SIM_IMPORT_FORMATS_QUATERNION_ORDER_H_
#define SINEW_SIM_IMPORT_FORMATS_QUATERNION_ORDER_H_

#include <mujoco/mujoco.h>

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "sim/import/formats/source_clip.h"

namespace sinew::import {

// The order of a recording's quaternions, which its file does not say, from the
// robot's kinematics.

// What speaks against a reading, means over frames.
struct OrderEvidence {
  // Distance of the model's lowest point from the floor (z = 0), at most 1 m.
  double height_m = 0;
  // Horizontal speed of the lowest body, at most 5 m/s: a body that is turned
  // round drags its standing foot along.
  double skate_m_per_s = 0;
  // 1 - cos of the angle between the root's z axis and the world's, 0 to 2.
  double lean = 0;

  // In metres: what is compared.
  double score() const { return height_m + 0.1 * skate_m_per_s + 0.1 * lean; }
};

struct OrderConclusion {
  OrderEvidence wxyz, xyzw;

  // The reading of the lower score.
  std::string order() const {
    return wxyz.score() <= xyzw.score() ? "wxyz" : "xyzw";
  }
  // The other reading is at least half as good.
  bool is_doubtful() const;
};

// Compares both readings of a clip whose facts.quaternion_order is unset, over
// frames spread over it. `model` has a free joint, and hinges of the clip's
// joint names; its other joints stay at qpos0, and joints that it lacks are
// left out. INVALID_ARGUMENT naming the clip: no free joint, none of the
// joints.
//
// Thread-safety: any thread. Ownership: borrows. Blocking: computes a few
// hundred kinematics, milliseconds. Errors: as said.
absl::StatusOr<OrderConclusion> CompareQuaternionOrders(const RobotClip& clip,
                                                        const mjModel& model);

// Where facts.quaternion_order is unset: takes the order that
// CompareQuaternionOrders favours, reads the rotations in it, and says so in
// the facts, as "concluded", and, if doubtful, in the warnings.
absl::Status SettleQuaternionOrder(const mjModel& model, RobotClip* clip);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_QUATERNION_ORDER_H_
