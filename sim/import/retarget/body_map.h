#ifndef SINEW_SIM_IMPORT_RETARGET_BODY_MAP_H_
#define SINEW_SIM_IMPORT_RETARGET_BODY_MAP_H_

#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "sim/import/retarget/hinge_chain.h"
#include "sim/import/retarget/import_model.h"
#include "sim/import/retarget/role_track.h"

namespace sinew::import {

// One body of the model that takes its rotation from a role.
struct MappedBody {
  int role;          // index into RoleTrack::roles
  int body;          // model body id
  int parent;        // index of the mapped body above, -1 for the root
  HingeChain chain;  // hinges between the parent and it
  // Body frame in the role's frame when both stand: it turns the model's zero
  // pose (say, arms down) into the source's (arms out).
  Eigen::Quaterniond alignment;
};

// Where a role is on the model.
struct RolePoint {
  int role;
  int mapped;                // index into BodyMap::bodies of the body it is on
  Eigen::Vector3d position;  // in that body's frame
};

// The role above in a limb ("left_hip" for "left_knee"), whose direction the
// bone between them is; empty: the role is none of knee, ankle, elbow, wrist.
std::string LimbParent(const std::string& role);

// How roles play on a model. The model's zero pose faces +x upright with an
// identity root rotation; limbs may point anywhere.
struct BodyMap {
  std::vector<MappedBody> bodies;  // root first, parents before children
  // Points of roles, parents before children: centres of the joints' hinges,
  // ends of limbs.
  std::vector<RolePoint> points;
  // Roles of large limbs that have no counterpart.
  std::vector<std::string> unmapped;
  // Lengths of the model's legs over the source's.
  double scale = 1;
  Eigen::Vector3d model_hips;  // middle of the hips in the root's frame

  // Index into `points`, -1: the model has no such point.
  int FindPoint(int role) const;
};

// Finds, by semantic, the hinges that play each role: those named like it or
// like one of its aliases (chest: thorax, torso, waist, ...), with any suffix
// after "_". Where two roles would move one body (spine and chest of a single
// waist), the one nearer to the limbs does: rotations are the world's, so that
// of joints in between is not lost.
//
// Alignment: a limb of the source's standing pose is the same limb of the
// model, whichever way either rest pose holds it; the soles are level where the
// source's feet stand still.
//
// INVALID_ARGUMENT naming the joint and what was looked for if hips, knees or
// ankles are missing. Precondition: the first joint is the root's free one.
absl::StatusOr<BodyMap> MakeBodyMap(const RoleTrack& track,
                                    const ImportModel& model);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_RETARGET_BODY_MAP_H_
