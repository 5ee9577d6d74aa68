#ifndef SINEW_SIM_WORLD_RECOVERY_H_
#define SINEW_SIM_WORLD_RECOVERY_H_

#include <algorithm>
#include <cstdint>

#include "common/config/recipe.h"
#include "common/random/philox.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "sim/character/character.h"
#include "sim/world/body_state.h"

namespace sinew::world {

// Where and how the body begins an episode, beside the reference's frame.
struct BodyStart {
  v1::StartKind kind = v1::START_KIND_REFERENCE;
  int fallen_state = 0;  // index into FallenStates; FALLEN and GET_UP only
  // From the reference's root, m, world; FAR only.
  double offset_x = 0, offset_y = 0;
  double turn = 0;  // about the vertical through the root, rad
  int recovery_steps = 0;
};

// Recovery from fail states, as in PHC's code (Luo et al. 2023):
//
//   start   fallen with probability fallen_share, far with far_share: sqrt(u)
//           far_offset metres off in a uniform direction; both turned by a
//           uniform angle; with get_up_share (not PHC's) fallen, on the frame
//           of a get-up that is nearest to the body (tracking_task.h)
//   clock   for `steps` steps (get_up_steps on a get-up) the reference stands
//           and nothing ends the episode but a divergence (tracking_task.h)
//   reward  d, d' distances between the roots before and after the step:
//             goal_weight * min(d - d', max_gain)
//             + near_factor * tracking  where d' < near_distance
//   seen    where a reference's root is farther than far_distance, the
//           reference is shown as the body itself, moved by far_distance
//           towards it: all differences are 0 but the direction
//
// Thread-safety: immutable. Ownership: none. Blocking: never; nothing
// allocates. Errors: none.
class RecoveryLaw {
 public:
  // `recipe` has its defaults filled.
  explicit RecoveryLaw(const v1::Recovery& recipe = {}) : recipe_(recipe) {}

  // Whether any episode starts otherwise than on the reference. Else no other
  // method may be called.
  bool on() const { return RecoveryShare(recipe_) > 0; }

  // The most steps in which an episode's reference stands.
  int most_steps() const {
    return std::max(recipe_.steps(), recipe_.get_up_steps());
  }

  // How an episode begins. `fallen_states`, how many there are, is >= 1 unless
  // FallenShare of the recipe is 0. Pure in its arguments; purpose and step are
  // set here.
  BodyStart Draw(RandomKey key, int fallen_states) const;

  // Reward of a step; distances in m; `tracking` is the weighted sum of
  // kernels.
  double Reward(double tracking, double before, double after) const;

  bool IsFar(double distance) const {
    return distance > recipe_.far_distance();
  }

  // What is shown instead of a reference that is far; false, and `reference` as
  // it was, where it is near.
  bool Hide(const BodyState& body, BodyState* reference) const;

 private:
  v1::Recovery recipe_;
};

// Distance between the roots, m.
inline double GoalDistance(const BodyState& body, const BodyState& reference) {
  return (reference.position[0] - body.position[0]).norm();
}

// Since when a body stands and tracks, over the frames of an evaluation: its
// mean body distance is below a bound, the reference is upright
// (get_up_frames.h), and its head (its root where the head is not tracked) is
// at least kHeadShare as high as the reference's.
//
// Thread-safety: one caller. Ownership: none. Blocking: never. Errors: none;
// a distance that is NaN does not track.
class RecoveryWatch {
 public:
  static constexpr double kHeadShare = 0.8;

  // `max_mean_distance` in m.
  RecoveryWatch(const character::Character& character,
                double max_mean_distance);

  // The next frame, counted from 1.
  void Add(double mean_distance, const BodyState& body,
           const BodyState& reference);

  // First of the frames that hold without a gap up to the last; -1: the last
  // does not hold.
  int recovered_at() const { return since_; }

 private:
  int head_ = 0;  // index into the tracked bodies
  double max_mean_distance_;
  double upright_height_;  // of the reference's root, m
  int frame_ = 0;
  int since_ = -1;
};

}  // namespace sinew::world

#endif  // SINEW_SIM_WORLD_RECOVERY_H_
