#ifndef SINEW_SIM_WORLD_ACTUATION_H_
#define SINEW_SIM_WORLD_ACTUATION_H_

#include <mujoco/mujoco.h>

#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "sim/character/character.h"

namespace sinew::world {

// Physics steps in a control step; the recipe's rates divide (task_check.h).
int Substeps(const v1::Physics& physics);

// What one control step of physics did.
struct ActuationResult {
  double power = 0;       // W: mean over substeps of sum_j |torque_j dq_j|
  bool diverged = false;  // see Actuation; the data is not to be used
};

// The torque law and the physics of a control step.
//
// At each physics step, for joint j with gains kp, kd and limit L:
//
//   torque_j       = clamp(kp (target_j - q_j) - kd dq_j, -L, L)
//   qfrc_applied_j = torque_j + kd dq_j
//
// The model's own joint damping is kd, so the passive force -kd dq cancels the
// last term: the sum is the clamped PD torque, yet its damping is always in
// MuJoCo's Euler integrator (implicit in velocity), also where the torque is
// clamped. The torque depends on target, q, dq and constants only.
//
// The target is held over the control step, or with `ramp` moves linearly from
// the previous target, which it reaches in the last substep.
//
// With an actuator model (VMP, Serifi et al. 2024, equations 9 to 11), joint by
// joint, with drive constants mu_s, dq_s, mu_d, tau_max, w_lim, w_max:
//
//   hi(w)    = tau_max clamp((w_max - w) / (w_max - w_lim), 0, 1)
//   motor_j  = clamp(kp (target_j - q_j) - kd dq_j, -hi(-dq_j), hi(dq_j))
//   torque_j = motor_j - mu_s tanh(dq_j / dq_s) - mu_d dq_j
//
// so the limit falls with the speed in the direction of the torque, and braking
// has all of tau_max. It has no state. Friction is explicit, kd implicit as
// above; power is that of the motor. Our departure: dq_s is at least
//
//   h mu_s / (I_j + h kd)
//
// with physics step h and I_j the joint's inertia as the model's reference pose
// has it (1 / dof_invweight0), since on a light joint explicit friction that is
// steeper would throw dq from one sign to the other, never to rest.
//
// Under conditions (randomisation.h) q_j + offset_j stands for q_j, and
// gain_j (kp ..., kd ...) for the gains.
//
// A simulation has diverged when MuJoCo warns of a bad position, velocity,
// acceleration or control, or a speed exceeds kMaxSpeed in any coordinate.
//
// Thread-safety: immutable. Ownership: borrows the model. Blocking: Run steps
// the physics (~0.1 ms); nothing allocates. Errors: Create's.
class Actuation {
 public:
  // m/s or rad/s; no limb of a tracked motion comes near.
  static constexpr double kMaxSpeed = 500;

  // What differs from the nominal body. Empty spans: nothing.
  struct Variation {
    const mjModel* model = nullptr;              // to be stepped
    absl::Span<const double> joint_offset = {};  // [J] rad
    absl::Span<const double> gain_scale = {};    // [J]
  };

  // Without an actuator model.
  Actuation(const character::Character& character, int substeps, bool ramp);

  // With the recipe's, if it has any (defaults filled). INVALID_ARGUMENT for a
  // drive whose joints the character has not, or a joint without a drive.
  static absl::StatusOr<Actuation> Create(const v1::ActuatorModel& recipe,
                                          const character::Character& character,
                                          int substeps, bool ramp);

  // Advances `data` by one control step; targets [J] rad. Applied forces on
  // other degrees of freedom stay as they are.
  ActuationResult Run(absl::Span<const double> previous_target,
                      absl::Span<const double> target, mjData* data) const;
  // The same of a body that differs.
  ActuationResult Run(absl::Span<const double> previous_target,
                      absl::Span<const double> target,
                      const Variation& variation, mjData* data) const;

  int substeps() const { return substeps_; }
  // Whether two joints have equal drives, as they all have without a model.
  bool SameDrive(int a, int b) const {
    return drives_.empty() || drives_[a] == drives_[b];
  }

 private:
  struct Joint {
    int qpos_address, dof_address;
    double stiffness, damping, limit;
    double softness;  // rad/s per Nm in a physics step
  };
  struct Drive {
    double static_friction, activation_velocity, viscous_friction;
    double max_torque, limit_velocity, max_velocity;

    // The largest torque that it gives at this velocity in the torque's
    // direction, Nm.
    double Limit(double velocity) const;
    // Against the velocity, Nm, of a joint of this softness.
    double Friction(double velocity, double softness) const;

    bool operator==(const Drive&) const = default;
  };
  // Sets qfrc_applied; returns the power, W.
  double ApplyTorques(absl::Span<const double> from,
                      absl::Span<const double> to, double share,
                      const Variation& variation, mjData* data) const;

  const mjModel* model_;
  std::vector<Joint> joints_;
  std::vector<Drive> drives_;  // [J], or none: no actuator model
  int substeps_;
  bool ramp_;
};

}  // namespace sinew::world

#endif  // SINEW_SIM_WORLD_ACTUATION_H_
