#ifndef SINEW_SIM_IMPORT_RETARGET_IMPORT_MODEL_H_
#define SINEW_SIM_IMPORT_RETARGET_IMPORT_MODEL_H_

#include <mujoco/mujoco.h>

#include <limits>
#include <string>
#include <vector>

#include "sim/character/character.h"
#include "sim/import/retarget/ground_points.h"

namespace sinew::import {

// One actuated hinge as the importer needs it.
struct ImportJoint {
  int qpos_address;
  int dof_address;
  double torque_limit;          // Nm
  double default_position = 0;  // rad
  // Range, rad; infinite where it has none.
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
};

// What a hinge of the model is, independent of its spelling, e.g. "left_hip_x".
struct SemanticJoint {
  std::string semantic;
  int joint;  // model joint id
};

// What the importer reads of a character. Borrows the model.
struct ImportModel {
  const mjModel* model = nullptr;
  std::vector<ImportJoint> joints;       // in the character's order
  std::vector<SemanticJoint> semantics;  // in the same order
  std::vector<GroundPoint> points;
  std::vector<int> feet;  // body ids
  double total_mass = 0;  // kg

  double weight() const {  // N
    return total_mass * -model->opt.gravity[2];
  }
  // The foot, an index into `feet`, that a ground point is on; -1: on none.
  int FootOf(int point) const;
};

// Precondition: the character outlives the result.
ImportModel MakeImportModel(const character::Character& character);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_RETARGET_IMPORT_MODEL_H_
