#include "sim/world/action.h"

#include <algorithm>

#include "common/check.h"

namespace sinew::world {
namespace {

// Radians per unit of action.
double Scale(const v1::Action& recipe, const character::JointInfo& joint) {
  if (joint.action_scale > 0) return joint.action_scale;
  if (recipe.strength_scale() > 0) {
    return recipe.strength_scale() * joint.torque_limit / joint.stiffness;
  }
  return recipe.scale();
}

}  // namespace

ActionLaw::ActionLaw(const v1::Action& recipe,
                     absl::Span<const character::JointInfo> joints)
    : placement_(recipe.placement()), clip_(recipe.clip()) {
  if (placement_ == v1::Action::PLACEMENT_UNSPECIFIED) {
    placement_ = v1::Action::PLACEMENT_AROUND_NEXT_REFERENCE;
  }
  for (const character::JointInfo& joint : joints) {
    joints_.push_back({.velocity_gain = recipe.velocity_feedforward()
                                            ? joint.damping / joint.stiffness
                                            : 0.0,
                       .torque_gain = recipe.torque_feedforward()
                                          ? 1.0 / joint.stiffness
                                          : 0.0,
                       .default_position = joint.default_position,
                       .scale = Scale(recipe, joint),
                       .low = joint.lower - recipe.range_margin(),
                       .high = joint.upper + recipe.range_margin()});
  }
}

double ActionLaw::ReferenceBase(const Joint& joint,
                                const motion::FrameView& frame, size_t j) {
  return frame.joint_position[j] +
         joint.velocity_gain * frame.joint_velocity[j] +
         joint.torque_gain * frame.feedforward_torque[j];
}

double ActionLaw::BaseOf(size_t j, double joint_position,
                         const motion::FrameView* next) const {
  switch (placement_) {
    case v1::Action::PLACEMENT_AROUND_CURRENT:
      return joint_position;
    case v1::Action::PLACEMENT_AROUND_NEXT_REFERENCE:
      if (next != nullptr) return ReferenceBase(joints_[j], *next, j);
      return joints_[j].default_position;
    default:
      return joints_[j].default_position;
  }
}

void ActionLaw::Base(absl::Span<const double> joint_position,
                     const motion::FrameView* next,
                     absl::Span<double> base) const {
  SINEW_DCHECK(base.size() == joints_.size());
  for (size_t j = 0; j < joints_.size(); ++j) {
    base[j] = BaseOf(j, joint_position[j], next);
  }
}

std::vector<double> ActionLaw::Scales() const {
  std::vector<double> scales;
  for (const Joint& joint : joints_) scales.push_back(joint.scale);
  return scales;
}

void ActionLaw::Target(absl::Span<const double> joint_position,
                       const motion::FrameView* next,
                       absl::Span<const float> action,
                       absl::Span<double> target) const {
  SINEW_DCHECK(action.size() == joints_.size());
  for (size_t j = 0; j < joints_.size(); ++j) {
    target[j] =
        Around(joints_[j], BaseOf(j, joint_position[j], next), action[j]);
  }
}

double ActionLaw::Around(const Joint& joint, double base, float action) const {
  const double unit = std::clamp(static_cast<double>(action), -clip_, clip_);
  return std::clamp(base + joint.scale * unit, joint.low, joint.high);
}

void ActionLaw::InitialTarget(absl::Span<const double> joint_position,
                              const motion::FrameView& start,
                              absl::Span<double> target) const {
  for (size_t j = 0; j < joints_.size(); ++j) {
    target[j] = joint_position[j];
    if (placement_ == v1::Action::PLACEMENT_AROUND_NEXT_REFERENCE) {
      target[j] = std::clamp(ReferenceBase(joints_[j], start, j),
                             joints_[j].low, joints_[j].high);
    }
  }
}

}  // namespace sinew::world
