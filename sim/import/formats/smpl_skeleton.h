#ifndef SINEW_SIM_IMPORT_FORMATS_SMPL_SKELETON_H_
#define SINEW_SIM_IMPORT_FORMATS_SMPL_SKELETON_H_

#include <Eigen/Core>

#include "sim/import/formats/source_clip.h"

namespace sinew::import {

// The skeleton that SMPL, SMPL-H and SMPL-X share: 22 body joints in SMPL's
// order and under its names (pelvis, left_hip, right_hip, spine1, left_knee,
// ...), and left_hand and right_hand, the roots of the fingers, as ends. In the
// rest pose (a T) it stands upright and looks along +x.
//
// The body models may not be shipped, so this is the mean body, whatever the
// file's betas and gender say, and nothing is scaled. Its joint locations, to
// 0.1 mm, are facts that ProtoMotions (github.com/NVlabs/ProtoMotions,
// Apache-2.0) prints as the body offsets of its smpl_humanoid.xml.
const SourceSkeleton& SmplSkeleton();

// Joints of the skeleton that files have rotations of: the first 22.
inline constexpr int kSmplBodyJoints = 22;

// Where the pelvis of the mean body lies in the model's own coordinates (y up,
// z forward), which `trans` moves and the root's rotation leaves in place.
Eigen::Vector3d SmplPelvis();

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_SMPL_SKELETON_H_
