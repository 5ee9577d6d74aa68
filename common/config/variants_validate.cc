#include "common/config/variants_validate.h"

#include <set>
#include <string>

#include "absl/strings/str_cat.h"
#include "common/config/recipe.h"

namespace sinew {
namespace {

// Sums of shares may be off by rounding.
constexpr double kRounding = 1e-9;
// Beyond these a number is a slip of the pen, and steps would overflow.
constexpr double kMaxSeconds = 3600;
constexpr double kMaxOffset = 1;       // rad
constexpr double kMaxImpulse = 1000;   // N s: 70 kg to 14 m/s
constexpr double kMaxDistance = 1000;  // m

void CheckRecovery(const v1::Recovery& recovery, FieldChecker& check) {
  check.Within(recovery.fallen_share(), 0, 1, "task.recovery.fallen_share");
  check.Within(recovery.far_share(), 0, 1, "task.recovery.far_share");
  check.Within(recovery.get_up_share(), 0, 1, "task.recovery.get_up_share");
  const double share = RecoveryShare(recovery);
  check.Require(share <= 1 + kRounding, "task.recovery",
                "fallen_share + far_share + get_up_share at most 1", share);
  check.Within(recovery.get_up_steps(), 0, 1 << 16,
               "task.recovery.get_up_steps");
  check.Within(recovery.far_offset(), 0, kMaxDistance,
               "task.recovery.far_offset");
  check.Within(recovery.far_distance(), 0, kMaxDistance,
               "task.recovery.far_distance");
  check.AtLeast(recovery.goal_weight(), 0, "task.recovery.goal_weight");
  check.AtLeast(recovery.max_gain(), 0, "task.recovery.max_gain");
  check.AtLeast(recovery.near_distance(), 0, "task.recovery.near_distance");
  check.AtLeast(recovery.near_factor(), 0, "task.recovery.near_factor");
  if (!(share > 0)) return;  // off
  check.Within(recovery.steps(), 1, 1 << 16, "task.recovery.steps");
  if (recovery.get_up_share() > 0) {
    check.AtLeast(recovery.get_up_steps(), 1, "task.recovery.get_up_steps");
  }
  check.Positive(recovery.far_offset(), "task.recovery.far_offset");
  check.Positive(recovery.far_distance(), "task.recovery.far_distance");
  check.Positive(recovery.max_gain(), "task.recovery.max_gain");
  check.Positive(recovery.near_distance(), "task.recovery.near_distance");
  check.Positive(recovery.near_factor(), "task.recovery.near_factor");
  check.Require(recovery.near_distance() <= recovery.far_distance(),
                "task.recovery.near_distance",
                absl::StrCat("<= task.recovery.far_distance (",
                             recovery.far_distance(), ")"),
                recovery.near_distance());
  check.Within(recovery.fallen_states(), 1, 1 << 16,
               "task.recovery.fallen_states");
}

void CheckRandomisation(const v1::Randomisation& random, FieldChecker& check) {
  check.Within(random.mass(), 0, 0.9, "task.randomisation.mass");
  check.Within(random.friction(), 0, 0.9, "task.randomisation.friction");
  check.Within(random.joint_offset(), 0, kMaxOffset,
               "task.randomisation.joint_offset");
  check.Within(random.gain(), 0, 0.9, "task.randomisation.gain");
  check.Within(random.push_impulse(), 0, kMaxImpulse,
               "task.randomisation.push_impulse");
  check.Within(random.push_interval(), 0, kMaxSeconds,
               "task.randomisation.push_interval");
  check.Within(random.push_seconds(), 0, kMaxSeconds,
               "task.randomisation.push_seconds");
  if (!(random.push_impulse() > 0)) return;
  check.Positive(random.push_seconds(), "task.randomisation.push_seconds");
  check.Require(random.push_seconds() <= random.push_interval(),
                "task.randomisation.push_seconds",
                absl::StrCat("<= task.randomisation.push_interval (",
                             random.push_interval(), ")"),
                random.push_seconds());
}

void CheckDrive(const v1::ActuatorModel::Drive& drive, const std::string& path,
                FieldChecker& check) {
  check.AtLeast(drive.static_friction(), 0, path + ".static_friction");
  check.Positive(drive.activation_velocity(), path + ".activation_velocity");
  check.AtLeast(drive.viscous_friction(), 0, path + ".viscous_friction");
  check.AtLeast(drive.max_torque(), 0, path + ".max_torque");
  check.Positive(drive.limit_velocity(), path + ".limit_velocity");
  check.Positive(drive.max_velocity(), path + ".max_velocity");
  check.Require(drive.max_velocity() > drive.limit_velocity(),
                path + ".max_velocity",
                absl::StrCat("> ", path, ".limit_velocity (",
                             drive.limit_velocity(), ")"),
                drive.max_velocity());
}

void CheckDrives(const v1::ActuatorModel& model, FieldChecker& check) {
  std::set<std::string> named;
  int unnamed = 0;
  for (int i = 0; i < model.drives_size(); ++i) {
    const v1::ActuatorModel::Drive& drive = model.drives(i);
    const std::string path =
        absl::StrCat("task.actuator_model.drives[", i, "]");
    CheckDrive(drive, path, check);
    if (drive.joints().empty()) ++unnamed;
    for (const std::string& joint : drive.joints()) {
      check.Require(named.insert(joint).second, path + ".joints",
                    "each joint in one drive only", joint);
    }
  }
  check.Require(unnamed <= 1, "task.actuator_model.drives",
                "at most one drive that names no joints", unnamed);
}

}  // namespace

void CheckVariants(const v1::Task& task, FieldChecker& check) {
  CheckRecovery(task.recovery(), check);
  CheckRandomisation(task.randomisation(), check);
  CheckDrives(task.actuator_model(), check);
}

}  // namespace sinew
