#include "sim/import/retarget/import_model.h"

namespace sinew::import {

ImportModel MakeImportModel(const character::Character& character) {
  ImportModel result;
  result.model = character.model();
  for (size_t i = 0; i < character.joints().size(); ++i) {
    const character::JointInfo& joint = character.joints()[i];
    const v1::Joint& proto = character.proto().joints(static_cast<int>(i));
    result.joints.push_back({joint.qpos_address, joint.dof_address,
                             joint.torque_limit, joint.default_position});
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
