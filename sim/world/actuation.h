#ifndef SINEW_SIM_WORLD_ACTUATION_H_
#define SINEW_SIM_WORLD_ACTUATION_H_

#include <mujoco/mujoco.h>

#include <vector>

#include "absl/types/span.h"
#include "sim/character/character.h"

namespace sinew::world {

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
// A simulation has diverged when MuJoCo warns of a bad position, velocity,
// acceleration or control, or a speed exceeds kMaxSpeed in any coordinate.
//
// Thread-safety: immutable. Ownership: borrows the model. Blocking: Run steps
// the physics (~0.1 ms); nothing allocates. Errors: none.
class Actuation {
 public:
  // m/s or rad/s; no limb of a tracked motion comes near.
  static constexpr double kMaxSpeed = 500;

  Actuation(const character::Character& character, int substeps, bool ramp);

  // Advances `data` by one control step; targets [J] rad. Applied forces on
  // other degrees of freedom stay as they are.
  ActuationResult Run(absl::Span<const double> previous_target,
                      absl::Span<const double> target, mjData* data) const;

  int substeps() const { return substeps_; }

 private:
  struct Joint {
    int qpos_address, dof_address;
    double stiffness, damping, limit;
  };
  // Sets qfrc_applied; returns the power, W.
  double ApplyTorques(absl::Span<const double> from,
                      absl::Span<const double> to, double share,
                      mjData* data) const;

  const mjModel* model_;
  std::vector<Joint> joints_;
  int substeps_;
  bool ramp_;
};

}  // namespace sinew::world

#endif  // SINEW_SIM_WORLD_ACTUATION_H_
