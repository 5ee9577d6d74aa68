#ifndef SINEW_TOOLS_TRAINING_STUDENT_REACH_H_
#define SINEW_TOOLS_TRAINING_STUDENT_REACH_H_

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "sim/character/character.h"

namespace sinew::tools {

// Whether a student's action law (sim/world/action.h), which limits actions to
// +-clip, reaches the teacher's targets, which labels are made of and nothing
// limits. Per joint, with scales in radians per unit:
//
//   ABSOLUTE   scale * clip >= the way from the default position to either end
//              of the range that the teacher's law has, margin included; joints
//              without a range are passed over
//   around the current pose, where the teacher's targets are not: scale * clip
//              >= the way from one end of the joint's range to the other one of
//              the teacher's; joints without a range are passed over
//   with the placement and feed-forward of the teacher: scale * clip >= that of
//              the teacher's law
//   around the next reference otherwise: refused
//
// `recipe` has its defaults filled; one without distillation passes.
// INVALID_ARGUMENT names the field, the joint, expected and found. Pure.
absl::Status CheckReach(const v1::Recipe& recipe,
                        absl::Span<const character::JointInfo> joints);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_STUDENT_REACH_H_
