#include "sim/world/actuation.h"

#include <algorithm>
#include <cmath>

namespace sinew::world {
namespace {

constexpr mjtWarning kDivergence[] = {mjWARN_BADQPOS, mjWARN_BADQVEL,
                                      mjWARN_BADQACC, mjWARN_BADCTRL};

bool Diverged(const mjModel* model, const mjData* data) {
  for (mjtWarning warning : kDivergence) {
    if (data->warning[warning].number > 0) return true;
  }
  for (int i = 0; i < model->nq; ++i) {
    if (!std::isfinite(data->qpos[i])) return true;
  }
  for (int i = 0; i < model->nv; ++i) {
    // Negated so that NaN counts.
    if (!(std::abs(data->qvel[i]) <= Actuation::kMaxSpeed)) return true;
  }
  return false;
}

}  // namespace

Actuation::Actuation(const character::Character& character, int substeps,
                     bool ramp)
    : model_(character.model()), substeps_(substeps), ramp_(ramp) {
  for (const character::JointInfo& joint : character.joints()) {
    joints_.push_back({.qpos_address = joint.qpos_address,
                       .dof_address = joint.dof_address,
                       .stiffness = joint.stiffness,
                       .damping = joint.damping,
                       .limit = joint.torque_limit});
  }
}

double Actuation::ApplyTorques(absl::Span<const double> from,
                               absl::Span<const double> to, double share,
                               mjData* data) const {
  double power = 0;
  for (size_t j = 0; j < joints_.size(); ++j) {
    const Joint& joint = joints_[j];
    const double target = from[j] + share * (to[j] - from[j]);
    const double velocity = data->qvel[joint.dof_address];
    const double torque =
        std::clamp(joint.stiffness * (target - data->qpos[joint.qpos_address]) -
                       joint.damping * velocity,
                   -joint.limit, joint.limit);
    data->qfrc_applied[joint.dof_address] = torque + joint.damping * velocity;
    power += std::abs(torque * velocity);
  }
  return power;
}

ActuationResult Actuation::Run(absl::Span<const double> previous_target,
                               absl::Span<const double> target,
                               mjData* data) const {
  for (mjtWarning warning : kDivergence) data->warning[warning].number = 0;
  ActuationResult result;
  const absl::Span<const double> from = ramp_ ? previous_target : target;
  for (int k = 1; k <= substeps_; ++k) {
    const double share = static_cast<double>(k) / substeps_;
    result.power += ApplyTorques(from, target, share, data);
    mj_step(model_, data);
  }
  result.power /= substeps_;
  result.diverged = Diverged(model_, data);
  return result;
}

}  // namespace sinew::world
