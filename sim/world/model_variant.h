#ifndef SINEW_SIM_WORLD_MODEL_VARIANT_H_
#define SINEW_SIM_WORLD_MODEL_VARIANT_H_

#include <mujoco/mujoco.h>

#include "sim/character/character.h"
#include "sim/character/model_ptr.h"
#include "sim/world/randomisation.h"

namespace sinew::world {

// A thread's own model of a character, with the masses and the friction of one
// environment after the other:
//
//   once per episode:  variant.Compute(&conditions);
//   at each step:      mj_step(variant.Use(conditions), data);
//
// Compute scales masses and inertias on a scratch copy, has MuJoCo work out
// what follows from them (mj_setConst: subtree masses, inverse weights, M0,
// mean inertia), and keeps those fields in the conditions; Use copies them into
// the model, a few hundred numbers. All else of the model is the character's,
// so what is used depends on the conditions alone.
//
// Thread-safety: one caller. Ownership: owns its models and data. Blocking:
// Compute takes about as long as a physics step. Errors: none; aborts if
// there is no memory.
class ModelVariant {
 public:
  explicit ModelVariant(const character::Character& character);

  // Doubles that Compute keeps.
  int num_fields() const;

  // Sets conditions->model_fields, which allocates the first time only.
  void Compute(Conditions* conditions);

  // The model until the next Use. Precondition: Compute was called.
  const mjModel* Use(const Conditions& conditions);

 private:
  const mjModel* base_;
  int floor_geom_;
  character::ModelPtr scratch_;
  character::ModelPtr model_;
  character::DataPtr data_;
};

}  // namespace sinew::world

#endif  // SINEW_SIM_WORLD_MODEL_VARIANT_H_
