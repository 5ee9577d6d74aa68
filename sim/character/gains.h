#ifndef SINEW_SIM_CHARACTER_GAINS_H_
#define SINEW_SIM_CHARACTER_GAINS_H_

#include <mujoco/mujoco.h>

#include <vector>

namespace sinew::character {

// Constants of the rule below.
struct GainRule {
  double bandwidth = 20;        // w, rad/s: about 3.2 Hz
  double damping_ratio = 1;     // zeta
  double stability_margin = 2;  // of the stiffness that just holds upright
  double least_inertia = 0.1;   // kg m^2, floor for small segments
};

// Gains of one hinge.
struct Gains {
  double stiffness;  // kp, Nm/rad
  double damping;    // kd, Nm s/rad
};

// PD gains of every hinge of a model, in order of joint ids, from physics:
//   kp = max(I w^2, margin * m g h / legs),  kd = 2 zeta kp / w
// I: inertia of everything beyond the joint about its axis at rest (all
// joints 0; diagonal of the mass matrix), at least `least_inertia`. The second term
// applies between the root and a foot only: m and h are mass and height over
// the joint of the centre of everything that the legs together hold up at that
// level, so m g h / legs is the stiffness below which an inverted pendulum on
// `legs` such joints falls. Hinges of one body share the largest of their gains (a ball joint is
// as stiff in every direction).
// `feet`: model body ids. Pure; the model is not changed.
std::vector<Gains> ComputeGains(const mjModel& model,
                                const std::vector<int>& feet,
                                const GainRule& rule = {});

}  // namespace sinew::character

#endif  // SINEW_SIM_CHARACTER_GAINS_H_
