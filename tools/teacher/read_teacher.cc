#include "tools/teacher/read_teacher.h"

#include "common/status_macros.h"
#include "sim/character/character.h"

namespace sinew::teacher {

TeacherPolicy PolicyOf(const bundle::Bundle& bundle) {
  TeacherPolicy policy = {.graph = bundle.graph,
                          .weights = bundle.weights,
                          .manifest = bundle.manifest,
                          .joint_action_scales = {}};
  for (const character::JointInfo& joint : bundle.character->joints()) {
    policy.joint_action_scales.push_back(joint.action_scale);
  }
  return policy;
}

absl::StatusOr<TeacherPolicy> ReadTeacher(const std::string& bundle_directory) {
  SINEW_ASSIGN_OR_RETURN(const bundle::Bundle bundle,
                         bundle::ReadBundle(bundle_directory));
  return PolicyOf(bundle);
}

}  // namespace sinew::teacher
