#include "sim/world/actuation.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/status_macros.h"

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

// The joint with this name, or else with this semantic; -1 if there is none.
int FindJoint(const character::Character& character, const std::string& name) {
  const std::vector<character::JointInfo>& joints = character.joints();
  for (size_t j = 0; j < joints.size(); ++j) {
    if (joints[j].name == name) return static_cast<int>(j);
  }
  for (const v1::Joint& joint : character.proto().joints()) {
    if (joint.semantic() == name) return FindJoint(character, joint.name());
  }
  return -1;
}

// Index of each joint's drive, [J].
absl::StatusOr<std::vector<int>> ChooseDrives(
    const v1::ActuatorModel& recipe, const character::Character& character) {
  const auto error = [&](absl::string_view field, absl::string_view expected,
                         absl::string_view found) {
    return absl::InvalidArgumentError(absl::StrCat(
        "recipe field task.actuator_model.drives", field, ": expected ",
        expected, " of character ", character.name(), ", found ", found));
  };
  int other = -1;  // the drive of joints that none names
  std::vector<int> choice(character.joints().size(), -1);
  for (int i = 0; i < recipe.drives_size(); ++i) {
    if (recipe.drives(i).joints().empty()) other = i;
    for (const std::string& name : recipe.drives(i).joints()) {
      const int joint = FindJoint(character, name);
      if (joint < 0 || choice[joint] >= 0) {
        return error(absl::StrCat("[", i, "].joints"), "joints, each once,",
                     absl::StrCat("\"", name, "\""));
      }
      choice[joint] = i;
    }
  }
  for (size_t j = 0; j < choice.size(); ++j) {
    if (choice[j] < 0) choice[j] = other;
    if (choice[j] < 0) {
      return error("", "a drive for every joint",
                   absl::StrCat("none for ", character.joints()[j].name));
    }
  }
  return choice;
}

// Velocity change per Nm that an explicit torque makes in a physics step, with
// the damping implicit: h / (I + h kd), in the model's reference pose.
double Softness(const mjModel* model, const character::JointInfo& joint) {
  const double step = model->opt.timestep;
  return step /
         (1 / model->dof_invweight0[joint.dof_address] + step * joint.damping);
}

}  // namespace

int Substeps(const v1::Physics& physics) {
  return static_cast<int>(
      std::lround(physics.physics_hz() / physics.control_hz()));
}

Actuation::Actuation(const character::Character& character, int substeps,
                     bool ramp)
    : model_(character.model()), substeps_(substeps), ramp_(ramp) {
  for (const character::JointInfo& joint : character.joints()) {
    joints_.push_back({.qpos_address = joint.qpos_address,
                       .dof_address = joint.dof_address,
                       .stiffness = joint.stiffness,
                       .damping = joint.damping,
                       .limit = joint.torque_limit,
                       .softness = Softness(character.model(), joint)});
  }
}

absl::StatusOr<Actuation> Actuation::Create(
    const v1::ActuatorModel& recipe, const character::Character& character,
    int substeps, bool ramp) {
  Actuation actuation(character, substeps, ramp);
  if (recipe.drives().empty()) return actuation;
  SINEW_ASSIGN_OR_RETURN(const std::vector<int> choice,
                         ChooseDrives(recipe, character));
  for (size_t j = 0; j < choice.size(); ++j) {
    const v1::ActuatorModel::Drive& drive = recipe.drives(choice[j]);
    actuation.drives_.push_back(
        {.static_friction = drive.static_friction(),
         .activation_velocity = drive.activation_velocity(),
         .viscous_friction = drive.viscous_friction(),
         .max_torque = drive.max_torque() > 0
                           ? drive.max_torque()
                           : character.joints()[j].torque_limit,
         .limit_velocity = drive.limit_velocity(),
         .max_velocity = drive.max_velocity()});
  }
  return actuation;
}

double Actuation::Drive::Limit(double velocity) const {
  return max_torque *
         std::clamp((max_velocity - velocity) / (max_velocity - limit_velocity),
                    0.0, 1.0);
}

double Actuation::Drive::Friction(double velocity, double softness) const {
  const double width =
      std::max(activation_velocity, static_friction * softness);
  return static_friction * std::tanh(velocity / width) +
         viscous_friction * velocity;
}

double Actuation::ApplyTorques(absl::Span<const double> from,
                               absl::Span<const double> to, double share,
                               const Variation& variation, mjData* data) const {
  double power = 0;
  for (size_t j = 0; j < joints_.size(); ++j) {
    const Joint& joint = joints_[j];
    const double offset =
        variation.joint_offset.empty() ? 0 : variation.joint_offset[j];
    const double gain =
        variation.gain_scale.empty() ? 1 : variation.gain_scale[j];
    const double target = from[j] + share * (to[j] - from[j]);
    const double velocity = data->qvel[joint.dof_address];
    const double position = data->qpos[joint.qpos_address] + offset;
    double motor = gain * (joint.stiffness * (target - position) -
                           joint.damping * velocity);
    double friction = 0;
    if (drives_.empty()) {
      motor = std::clamp(motor, -joint.limit, joint.limit);
    } else {
      const Drive& drive = drives_[j];
      motor = std::clamp(motor, -drive.Limit(-velocity), drive.Limit(velocity));
      friction = drive.Friction(velocity, joint.softness);
    }
    data->qfrc_applied[joint.dof_address] =
        motor - friction + joint.damping * velocity;
    power += std::abs(motor * velocity);
  }
  return power;
}

ActuationResult Actuation::Run(absl::Span<const double> previous_target,
                               absl::Span<const double> target,
                               mjData* data) const {
  return Run(previous_target, target, {.model = model_}, data);
}

ActuationResult Actuation::Run(absl::Span<const double> previous_target,
                               absl::Span<const double> target,
                               const Variation& variation, mjData* data) const {
  for (mjtWarning warning : kDivergence) data->warning[warning].number = 0;
  ActuationResult result;
  const absl::Span<const double> from = ramp_ ? previous_target : target;
  for (int k = 1; k <= substeps_; ++k) {
    const double share = static_cast<double>(k) / substeps_;
    result.power += ApplyTorques(from, target, share, variation, data);
    mj_step(variation.model, data);
  }
  result.power /= substeps_;
  result.diverged = Diverged(variation.model, data);
  return result;
}

}  // namespace sinew::world
