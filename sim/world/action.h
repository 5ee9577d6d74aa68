#ifndef SINEW_SIM_WORLD_ACTION_H_
#define SINEW_SIM_WORLD_ACTION_H_

#include <vector>

#include "absl/types/span.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "sim/character/character.h"
#include "sim/motion/library.h"

namespace sinew::world {

// The action law: what joint-position target an action means.
//
// For joint j with gains kp, kd, and the reference frame of t + 1 (hats):
//
//   base_j   = q^_j                                  AROUND_NEXT_REFERENCE
//              + kd / kp * dq^_j                       if velocity_feedforward
//              + tau^_j / kp                           if torque_feedforward
//            = q_j of the body                       AROUND_CURRENT
//            = default position                      ABSOLUTE
//   target_j = clamp(base_j + scale_j * clamp(action_j, +-clip),
//                    lower_j - range_margin, upper_j + range_margin)
//
// scale_j is the joint's own action_scale; where that is 0, strength_scale *
// torque limit / kp; where that is off, the recipe's scale. The feed-forwards
// make a held target ask, at zero error, for the reference's
// torque: kp (base - q) - kd dq = kp (q^ - q) + kd (dq^ - dq) + tau^. The range
// margin leaves them room at the ends of the range.
//
// Thread-safety: immutable. Ownership: none. Blocking: never; nothing
// allocates after construction. Errors: none; non-finite in gives non-finite
// out.
class ActionLaw {
 public:
  // `recipe` has its defaults filled; `joints` are J in action order.
  ActionLaw(const v1::Action& recipe,
            absl::Span<const character::JointInfo> joints);

  // Targets [J] rad of an action [J], given q [J] of the body and the reference
  // frame of t + 1. Null where no reference is to be seen (recovery.h): a
  // target that would be placed around it is placed around the default pose.
  void Target(absl::Span<const double> joint_position,
              const motion::FrameView* next, absl::Span<const float> action,
              absl::Span<double> target) const;

  // Bases [J] rad, what Target adds scaled actions to before it limits the sum;
  // `next` as there. What is not limited has
  //   target = base + scale * action.
  void Base(absl::Span<const double> joint_position,
            const motion::FrameView* next, absl::Span<double> base) const;

  // Radians per unit of action of each joint, [J].
  std::vector<double> Scales() const;

  // What counts as the target before the first step of an episode that starts
  // with the reference frame `start` and the body's q: the base around that
  // frame, or q itself where targets are not placed around the reference.
  void InitialTarget(absl::Span<const double> joint_position,
                     const motion::FrameView& start,
                     absl::Span<double> target) const;

 private:
  struct Joint {
    double velocity_gain;  // s: kd / kp, or 0
    double torque_gain;    // rad/Nm: 1 / kp, or 0
    double default_position;
    double scale;  // rad per unit of action
    double low, high;
  };
  // Limits base + scale * action.
  double Around(const Joint& joint, double base, float action) const;
  // Base of joint j, rad; `next` as in Target.
  double BaseOf(size_t j, double joint_position,
                const motion::FrameView* next) const;
  // Base around a reference frame, rad.
  static double ReferenceBase(const Joint& joint,
                              const motion::FrameView& frame, size_t j);

  v1::Action::Placement placement_;
  double clip_;
  std::vector<Joint> joints_;
};

}  // namespace sinew::world

#endif  // SINEW_SIM_WORLD_ACTION_H_
