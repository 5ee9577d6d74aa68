#include "sim/import/retarget/self_contact.h"

#include <algorithm>

#include "sim/character/model_ptr.h"

namespace sinew::import {
namespace {

using Eigen::Vector3d;

// Bodies without joints are part of the one that they hang on.
int Joined(const mjModel& model, int body) { return model.body_weldid[body]; }

bool AreNeighbours(const mjModel& model, int a, int b) {
  return a == b || Joined(model, model.body_parentid[a]) == b ||
         Joined(model, model.body_parentid[b]) == a;
}

bool IsExcluded(const mjModel& model, int a, int b) {
  const int signature = (std::min(a, b) << 16) + std::max(a, b);
  const int* begin = model.exclude_signature;
  const int* end = begin + model.nexclude;
  return std::find(begin, end, signature) != end;
}

bool IsSolid(const mjModel& model, int geom) {
  return model.geom_bodyid[geom] > 0 &&
         (model.geom_contype[geom] != 0 || model.geom_conaffinity[geom] != 0);
}

bool SpheresMeet(const mjModel& model, const mjData& data, int a, int b) {
  const Eigen::Map<const Vector3d> at(data.geom_xpos + 3 * a);
  const Eigen::Map<const Vector3d> to(data.geom_xpos + 3 * b);
  const double reach = model.geom_rbound[a] + model.geom_rbound[b];
  return (at - to).squaredNorm() < reach * reach;
}

}  // namespace

SelfContacts::SelfContacts(const ImportModel& model) : model_(*model.model) {
  const character::DataPtr data(mj_makeData(&model_));
  std::copy_n(model_.qpos0, model_.nq, data->qpos);
  mj_kinematics(&model_, data.get());
  for (int a = 0; a < model_.ngeom; ++a) {
    for (int b = a + 1; b < model_.ngeom; ++b) {
      if (!IsSolid(model_, a) || !IsSolid(model_, b)) continue;
      const int body_a = Joined(model_, model_.geom_bodyid[a]);
      const int body_b = Joined(model_, model_.geom_bodyid[b]);
      if (AreNeighbours(model_, body_a, body_b) ||
          IsExcluded(model_, model_.geom_bodyid[a], model_.geom_bodyid[b])) {
        continue;
      }
      if (SpheresMeet(model_, *data, a, b) &&
          mj_geomDistance(&model_, data.get(), a, b, 1.0, nullptr) <= 0) {
        continue;
      }
      pairs_.emplace_back(a, b);
    }
  }
}

double SelfContacts::Deepest(const mjData& data) const {
  double deepest = 0;
  for (const SelfContact& contact : Find(data, 0)) {
    deepest = std::max(deepest, contact.depth);
  }
  return deepest;
}

std::vector<SelfContact> SelfContacts::Find(const mjData& data,
                                            double tolerance) const {
  std::vector<SelfContact> found;
  for (const auto& [a, b] : pairs_) {
    if (!SpheresMeet(model_, data, a, b)) continue;
    mjtNum segment[6] = {0};
    // Changes nothing but the data's scratch memory.
    const double distance = mj_geomDistance(&model_, const_cast<mjData*>(&data),
                                            a, b, 1e-3, segment);
    if (distance > -tolerance) continue;
    const Vector3d from(segment), to(segment + 3);
    if ((to - from).norm() < 1e-9) continue;
    found.push_back({{model_.geom_bodyid[a], model_.geom_bodyid[b]},
                     {from, to},
                     -distance});
  }
  return found;
}

}  // namespace sinew::import
