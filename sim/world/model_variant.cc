#include "sim/world/model_variant.h"

#include <algorithm>
#include <numeric>

#include "common/check.h"

namespace sinew::world {
namespace {

// Calls function(first number, count) for each field that masses and friction
// decide, in a fixed order, friction last. Model: mjModel, const or not.
template <typename Model, typename Function>
void ForEachField(Model* model, int floor_geom, Function&& function) {
  const int bodies = static_cast<int>(model->nbody);
  const int dofs = static_cast<int>(model->nv);
  function(model->body_mass, bodies);
  function(model->body_inertia, 3 * bodies);
  function(model->body_subtreemass, bodies);
  function(model->body_invweight0, 2 * bodies);
  function(model->dof_invweight0, dofs);
  function(model->dof_M0, dofs);
  function(model->tendon_invweight0, static_cast<int>(model->ntendon));
  function(&model->stat.meaninertia, 1);
  function(model->geom_friction + 3 * floor_geom, 1);
}

// mjStatistic's: the mean of the diagonal of the inertia matrix at qpos0.
mjtNum MeanInertia(const mjModel& model) {
  return std::accumulate(model.dof_M0, model.dof_M0 + model.nv, mjtNum{0}) /
         static_cast<mjtNum>(model.nv);
}

}  // namespace

ModelVariant::ModelVariant(const character::Character& character)
    : base_(character.model()),
      floor_geom_(character.floor_geom()),
      scratch_(mj_copyModel(nullptr, base_)),
      model_(mj_copyModel(nullptr, base_)),
      data_(mj_makeData(base_)) {
  SINEW_CHECK(scratch_ != nullptr && model_ != nullptr && data_ != nullptr)
      << "no memory for models of " << character.name();
}

int ModelVariant::num_fields() const {
  int count = 0;
  ForEachField(model_.get(), floor_geom_,
               [&](const mjtNum*, int size) { count += size; });
  return count;
}

void ModelVariant::Compute(Conditions* conditions) {
  bool masses_differ = false;
  for (int body = 0; body < base_->nbody; ++body) {
    const double scale = conditions->mass_scale[body];
    masses_differ = masses_differ || scale != 1;
    scratch_->body_mass[body] = scale * base_->body_mass[body];
    for (int i = 3 * body; i < 3 * body + 3; ++i) {
      scratch_->body_inertia[i] = scale * base_->body_inertia[i];
    }
  }
  if (masses_differ) {
    mj_resetData(scratch_.get(), data_.get());
    mj_setConst(scratch_.get(), data_.get());
    // What it leaves as compiled.
    scratch_->stat.meaninertia = MeanInertia(*scratch_);
  }
  conditions->model_fields.resize(num_fields());
  double* to = conditions->model_fields.data();
  const mjModel* from = masses_differ ? scratch_.get() : base_;
  ForEachField(from, floor_geom_, [&](const mjtNum* numbers, int size) {
    to = std::copy_n(numbers, size, to);
  });
  conditions->model_fields.back() *= conditions->friction_scale;
}

const mjModel* ModelVariant::Use(const Conditions& conditions) {
  SINEW_DCHECK(static_cast<int>(conditions.model_fields.size()) ==
               num_fields());
  const double* from = conditions.model_fields.data();
  ForEachField(model_.get(), floor_geom_, [&](mjtNum* to, int size) {
    std::copy_n(from, size, to);
    from += size;
  });
  return model_.get();
}

}  // namespace sinew::world
