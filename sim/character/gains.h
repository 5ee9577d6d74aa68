#ifndef SINEW_SIM_CHARACTER_GAINS_H_
#define SINEW_SIM_CHARACTER_GAINS_H_

#include <mujoco/mujoco.h>

#include <vector>

namespace sinew::character {

// Constants of the rule below.
struct GainRule {
  // What a gain has to accelerate: everything beyond the joint, or only the
  // drive's own rotor and gears (the joint's armature), as makers of robots
  // do, since a stiffer loop would outrun the drive.
  enum class Inertia { kBeyondJoint, kArmature };

  Inertia inertia = Inertia::kBeyondJoint;
  double bandwidth = 20;        // w, rad/s: about 3.2 Hz
  double damping_ratio = 1;     // zeta
  double stability_margin = 2;  // over the stiffness that just holds upright
  double least_inertia = 0.1;   // kg m^2, floor for small segments
};

// The rules of our own characters; a test holds their text protos against them.
GainRule HumanoidGainRule();
GainRule G1GainRule();
GainRule H12GainRule();

// Gains of one hinge.
struct Gains {
  double stiffness;  // kp, Nm/rad
  double damping;    // kd, Nm s/rad
};

// PD gains of every hinge of a model, in order of joint ids, from physics:
//   kp = max(I w^2, margin * m g h / n),  kd = 2 zeta kp / w
// I: inertia about the joint's axis at rest (all joints 0): diagonal of the
// mass matrix, or the armature; at least `least_inertia`. The second term: m
// and h are mass and height over the joint of the centre of what it holds up,
// so m g h / n is the stiffness below which that topples like an inverted
// pendulum. Between the root and a foot it is all that the legs together hold
// up at that level, and n the number of feet; elsewhere it is what lies beyond
// the joint, if that is above it, and n = 1. It counts by the square of the
// sine between axis and vertical (nothing topples about a vertical axis).
// Joints in series give way together: a body stands by itself if the sum of m g
// h / (n kp) over ankle, knee, hip and waist is below 1. Hinges of one body
// share the largest of their gains (a ball joint is as stiff in every
// direction). `feet`: model body ids. Pure; the model is not changed.
std::vector<Gains> ComputeGains(const mjModel& model,
                                const std::vector<int>& feet,
                                const GainRule& rule);

}  // namespace sinew::character

#endif  // SINEW_SIM_CHARACTER_GAINS_H_
