#ifndef SINEW_SIM_IMPORT_RETARGET_BODY_MAP_H_
#define SINEW_SIM_IMPORT_RETARGET_BODY_MAP_H_

#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "sim/import/formats/source_clip.h"
#include "sim/import/retarget/hinge_chain.h"

namespace sinew::import {

// What a model's hinge is, independent of its spelling, e.g. "left_hip_x".
struct SemanticJoint {
  std::string semantic;
  int joint;  // model joint id
};

// One body of the model that takes its rotation from a joint of the source.
struct MappedBody {
  int source;             // source joint
  int body;               // model body id
  int parent;             // index of the mapped body above, -1 for the root
  HingeChain chain;       // hinges between the parent and it
  // Body frame in the source joint's frame when both are in the same pose: it
  // turns the model's rest pose (say, arms out) into the source's (arms down).
  Eigen::Quaterniond alignment;
};

// How a source skeleton plays on a model. The model's zero pose faces +x
// upright with an identity root rotation; limbs may point anywhere.
struct BodyMap {
  std::vector<MappedBody> bodies;  // root first, parents before children
  // Source joints that have no counterpart; their rotation is lost.
  std::vector<std::string> unmapped;
  // Lengths of the model's legs over the source's.
  double scale = 1;
  // Middle of the hips in the frame of the source's root and the model's.
  Eigen::Vector3d source_hips, model_hips;
};

// Finds, by semantic, the hinges that play each source joint: those named like
// it or like one of its aliases (chest: abdomen, waist, ...), with any suffix
// after "_". INVALID_ARGUMENT naming the joint and what was looked for if hips,
// knees or ankles are missing, or if the root's first body has no free joint.
absl::StatusOr<BodyMap> MakeBodyMap(
    const SourceSkeleton& skeleton, const mjModel& model,
    const std::vector<SemanticJoint>& semantics);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_RETARGET_BODY_MAP_H_
