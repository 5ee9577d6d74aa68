#include "sim/import/retarget/import_model.h"

#include <algorithm>

namespace sinew::import {

int ImportModel::FootOf(int point) const {
  const auto foot = std::find(feet.begin(), feet.end(), points[point].body);
  return foot == feet.end() ? -1 : static_cast<int>(foot - feet.begin());
}

ImportModel MakeImportModel(const character::Character& character) {
  ImportModel result;
  result.model = character.model();
  for (size_t i = 0; i < character.joints().size(); ++i) {
    const character::JointInfo& joint = character.joints()[i];
    const v1::Joint& proto = character.proto().joints(static_cast<int>(i));
    ImportJoint& hinge = result.joints.emplace_back(
        ImportJoint{joint.qpos_address, joint.dof_address, joint.torque_limit,
                    joint.default_position});
    if (result.model->jnt_limited[joint.joint_id]) {
      hinge.lower = result.model->jnt_range[2 * joint.joint_id];
      hinge.upper = result.model->jnt_range[2 * joint.joint_id + 1];
    }
    result.semantics.push_back(
        {proto.semantic().empty() ? joint.name : proto.semantic(),
         joint.joint_id});
  }
  result.points = MakeGroundPoints(*character.model(), character.floor_geom());
  result.feet = character.foot_bodies();
  result.total_mass = character.total_mass();
  return result;
}

}  // namespace sinew::import
