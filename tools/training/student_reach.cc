#include "tools/training/student_reach.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "absl/strings/str_format.h"
#include "absl/strings/string_view.h"
#include "sim/world/action.h"

namespace sinew::tools {
namespace {

bool SameLaw(const v1::Action& a, const v1::Action& b) {
  return a.placement() == b.placement() &&
         a.velocity_feedforward() == b.velocity_feedforward() &&
         a.torque_feedforward() == b.torque_feedforward();
}

// The farther end of the range, from the default position, rad.
double FartherEnd(const character::JointInfo& joint, double margin) {
  return std::max(joint.upper + margin - joint.default_position,
                  joint.default_position - (joint.lower - margin));
}

}  // namespace

absl::Status CheckReach(const v1::Recipe& recipe,
                        absl::Span<const character::JointInfo> joints) {
  if (!recipe.has_distillation()) return absl::OkStatus();
  const v1::Action& student = recipe.task().action();
  const v1::Action& teacher = recipe.distillation().teacher_action();
  const bool absolute = student.placement() == v1::Action::PLACEMENT_ABSOLUTE;
  const bool same = SameLaw(student, teacher);
  if (!absolute && !same &&
      student.placement() == v1::Action::PLACEMENT_AROUND_NEXT_REFERENCE) {
    return absl::InvalidArgumentError(
        "recipe field task.action: expected the teacher's placement, "
        "velocity_feedforward and torque_feedforward around the next "
        "reference, or some labels would be out of the student's reach, found "
        "others");
  }
  const std::vector<double> own = world::ActionLaw(student, joints).Scales();
  const std::vector<double> theirs = world::ActionLaw(teacher, joints).Scales();
  const absl::string_view what =
      absolute ? "from the default position to the end of the teacher's range"
      : same   ? "clip * scale of the teacher's law"
               : "from one end of the range to the other of the teacher's";
  for (size_t j = 0; j < joints.size(); ++j) {
    const double expected =
        absolute ? FartherEnd(joints[j], teacher.range_margin())
        : same   ? teacher.clip() * theirs[j]
                 : joints[j].upper - joints[j].lower + teacher.range_margin();
    const double found = student.clip() * own[j];
    if (!std::isfinite(expected) || found >= expected) continue;
    return absl::InvalidArgumentError(absl::StrFormat(
        "recipe field task.action.clip: joint %s: expected clip * scale >= %g "
        "rad (%s), or some labels would be out of the student's reach, found "
        "%g rad",
        joints[j].name, expected, what, found));
  }
  return absl::OkStatus();
}

}  // namespace sinew::tools
