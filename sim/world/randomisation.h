#ifndef SINEW_SIM_WORLD_RANDOMISATION_H_
#define SINEW_SIM_WORLD_RANDOMISATION_H_

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "common/random/philox.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "sim/character/character.h"

namespace sinew::world {

// What an episode of one environment has of its own. Sized by
// Randomisation::MakeConditions; a pure function of (seed, environment,
// episode), so no order carries it.
struct Conditions {
  RandomKey key;                     // of the pushes
  std::vector<double> mass_scale;    // [nbody] of mass and inertia
  double friction_scale = 1;         // of the floor
  std::vector<double> joint_offset;  // [J] rad: what is measured is q + offset
  std::vector<double> gain_scale;    // [J] of stiffness and damping
  // What ModelVariant puts into its model.
  std::vector<double> model_fields;
};

// A force on a body at its centre of mass, world frame.
struct Push {
  int body = 0;                 // model body id; 0: none
  double force[3] = {0, 0, 0};  // N
};

// Domain randomisation after VMP (Serifi et al. 2024), whose sizes are lost in
// part: they are the recipe's. u, u' ... are uniform on [0, 1):
//
//   each body     mass, inertia *= 1 + mass (2 u - 1)
//   floor         sliding friction *= 1 + friction (2 u - 1)
//   each joint    offset = joint_offset (2 u - 1)
//                 stiffness, damping *= 1 + gain (2 u' - 1)
//   pushes        time is cut into stretches of push_interval; in each, one
//                 push of push_seconds (both in whole control steps, at least
//                 one) begins at a uniform step that leaves it room, on a
//                 uniform one of the bodies, in a uniform direction, with the
//                 impulse u push_impulse
//
// Thread-safety: immutable. Ownership: none. Blocking: never; but for
// MakeConditions nothing allocates. Errors: Create names a push body that the
// character has not.
class Randomisation {
 public:
  // `recipe` has its defaults filled.
  static absl::StatusOr<Randomisation> Create(
      const v1::Recipe& recipe, const character::Character& character);

  // Whether anything is randomised. Else no other method need be called.
  bool on() const { return on_; }
  bool in_evaluation() const { return recipe_.in_evaluation(); }

  Conditions MakeConditions() const;

  // Draws everything but model_fields. Purpose and step of the key are set
  // here.
  void Draw(RandomKey key, Conditions* conditions) const;

  // What pushes the body during the control step that begins at `step`.
  Push PushAt(const Conditions& conditions, int32_t step) const;

 private:
  Randomisation() = default;
  absl::Status FindPushBodies(const character::Character& character);

  v1::Randomisation recipe_;
  bool on_ = false;
  int num_bodies_ = 0;
  int num_joints_ = 0;
  std::vector<int> push_bodies_;  // model body ids
  uint64_t interval_steps_ = 1;
  uint64_t push_steps_ = 1;
  double push_seconds_ = 0;  // of push_steps_
};

}  // namespace sinew::world

#endif  // SINEW_SIM_WORLD_RANDOMISATION_H_
