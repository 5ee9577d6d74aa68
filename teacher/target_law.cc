#include "teacher/target_law.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/config/recipe.h"
#include "common/status_macros.h"

namespace sinew::teacher {
namespace {

v1::Action WithActionDefaults(const v1::Action& action) {
  v1::Recipe recipe;
  *recipe.mutable_task()->mutable_action() = action;
  return WithDefaults(std::move(recipe)).task().action();
}

double Scale(const v1::Action& action, const v1::BundleJoint& joint,
             double own) {
  if (own > 0) return own;
  if (action.strength_scale() > 0) {
    return action.strength_scale() * joint.torque_limit() / joint.stiffness();
  }
  return action.scale();
}

absl::Status Wrong(const std::string& field, absl::string_view expected,
                   double found) {
  return absl::InvalidArgumentError(absl::StrCat(
      "manifest: ", field, ": expected ", expected, ", found ", found));
}

absl::Status CheckLaw(const v1::Action& action) {
  if (!std::isfinite(action.clip()) || action.clip() <= 0) {
    return Wrong("action.clip", "a finite number > 0", action.clip());
  }
  if (!std::isfinite(action.range_margin()) || action.range_margin() < 0) {
    return Wrong("action.range_margin", "a finite number >= 0",
                 action.range_margin());
  }
  return absl::OkStatus();
}

absl::Status CheckSizes(const TeacherPolicy& policy) {
  const auto joints = static_cast<size_t>(policy.manifest.joints_size());
  if (policy.manifest.action_width() != policy.manifest.joints_size()) {
    return Wrong("action_width", absl::StrCat(joints, " as there are joints"),
                 static_cast<double>(policy.manifest.action_width()));
  }
  if (policy.joint_action_scales.size() != joints) {
    return absl::InvalidArgumentError(
        absl::StrCat("joint_action_scales: expected one for each of ", joints,
                     " joints, found ", policy.joint_action_scales.size()));
  }
  return absl::OkStatus();
}

}  // namespace

TargetLaw::TargetLaw(v1::Action action, std::vector<Joint> joints)
    : action_(std::move(action)),
      clip_(action_.clip()),
      joints_(std::move(joints)) {}

absl::StatusOr<TargetLaw> TargetLaw::Create(const TeacherPolicy& policy) {
  SINEW_RETURN_IF_ERROR(CheckSizes(policy));
  const v1::Action action = WithActionDefaults(policy.manifest.action());
  SINEW_RETURN_IF_ERROR(CheckLaw(action));
  std::vector<Joint> joints;
  for (int j = 0; j < policy.manifest.joints_size(); ++j) {
    const v1::BundleJoint& from = policy.manifest.joints(j);
    const std::string field = absl::StrCat("joints[", j, "] (", from.name());
    const Joint joint = {
        .scale = Scale(action, from, policy.joint_action_scales[j]),
        .low = from.lower() - action.range_margin(),
        .high = from.upper() + action.range_margin()};
    if (!std::isfinite(joint.scale) || joint.scale <= 0) {
      return Wrong(field + "): radians per unit of action",
                   "a finite number > 0", joint.scale);
    }
    if (!(from.lower() <= from.upper())) {
      return Wrong(field + ").upper", absl::StrCat(">= ", from.lower()),
                   from.upper());
    }
    joints.push_back(joint);
  }
  return TargetLaw(action, std::move(joints));
}

void TargetLaw::Target(absl::Span<const double> base,
                       absl::Span<const float> action,
                       absl::Span<double> target) const {
  for (size_t j = 0; j < joints_.size(); ++j) {
    const Joint& joint = joints_[j];
    const double unit =
        std::clamp(static_cast<double>(action[j]), -clip_, clip_);
    target[j] = std::clamp(base[j] + joint.scale * unit, joint.low, joint.high);
  }
}

}  // namespace sinew::teacher
