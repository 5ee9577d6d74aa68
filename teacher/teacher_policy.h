#ifndef SINEW_TEACHER_TEACHER_POLICY_H_
#define SINEW_TEACHER_TEACHER_POLICY_H_

#include <vector>

#include "common/policy/safetensors.h"
#include "proto/sinew/v1/bundle.pb.h"
#include "proto/sinew/v1/graph.pb.h"

namespace sinew::teacher {

// What a teacher is made of: a bundle that was read and checked elsewhere
// (tools/teacher/read_teacher.h). Its graph "policy" answers, whatever is
// inside: one policy, a composer, a student with a latent.
struct TeacherPolicy {
  v1::PolicyGraph graph;
  TensorMap weights;
  // Joints with gains and limits, action law, widths, digests.
  v1::BundleManifest manifest;
  // Radians per unit of action that joints have of their own
  // (character::JointInfo::action_scale; old manifests lack it), 0: as the
  // action law says. One per joint.
  std::vector<double> joint_action_scales;
};

}  // namespace sinew::teacher

#endif  // SINEW_TEACHER_TEACHER_POLICY_H_
