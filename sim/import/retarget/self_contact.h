#ifndef SINEW_SIM_IMPORT_RETARGET_SELF_CONTACT_H_
#define SINEW_SIM_IMPORT_RETARGET_SELF_CONTACT_H_

#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <utility>
#include <vector>

#include "sim/import/retarget/import_model.h"

namespace sinew::import {

// Where two bodies of a model are inside one another.
struct SelfContact {
  int body[2];
  Eigen::Vector3d point[2];  // deepest, on the surface of each, world
  double depth;              // m, > 0

  // Unit vector that moves the second body out of the first.
  Eigen::Vector3d normal() const { return (point[0] - point[1]).normalized(); }
};

// Pairs of geoms of a model that should not meet: of bodies that no single
// joint connects, apart in the zero pose, and not excluded by the model.
//
// Thread-safety: const methods from any thread. Ownership: borrows the model.
// Blocking: never. Errors: none.
class SelfContacts {
 public:
  explicit SelfContacts(const ImportModel& model);

  // Depth of the deepest pair, 0: none.
  double Deepest(const mjData& data) const;

  // Pairs deeper than `tolerance` in a pose; `data` must hold geom poses.
  std::vector<SelfContact> Find(const mjData& data, double tolerance) const;

 private:
  const mjModel& model_;
  std::vector<std::pair<int, int>> pairs_;  // geoms
};

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_RETARGET_SELF_CONTACT_H_
