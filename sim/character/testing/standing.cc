#include "sim/character/testing/standing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include "common/check.h"
#include "common/random/philox.h"
#include "sim/character/mirror_joints.h"
#include "sim/character/model_ptr.h"

namespace sinew::character::testing {
namespace {

// Height of a geom's lowest point.
double Lowest(const mjModel& model, const mjData& data, int geom) {
  const double* size = model.geom_size + 3 * geom;
  const double* up = data.geom_xmat + 9 * geom + 6;  // world z by local axes
  const double z = data.geom_xpos[3 * geom + 2];
  switch (model.geom_type[geom]) {
    case mjGEOM_SPHERE:
      return z - size[0];
    case mjGEOM_CAPSULE:
      return z - std::abs(up[2]) * size[1] - size[0];
    default:
      SINEW_CHECK(model.geom_type[geom] == mjGEOM_BOX) << "geom " << geom;
      return z - std::abs(up[0]) * size[0] - std::abs(up[1]) * size[1] -
             std::abs(up[2]) * size[2];
  }
}

// Joint coordinates in action order, drawn at random.
std::vector<float> DrawJoints(const Character& character, uint64_t seed) {
  std::vector<float> joints(character.joints().size());
  FillNormal({.seed = seed}, absl::MakeSpan(joints));
  for (float& joint : joints) joint *= 0.3F;
  return joints;
}

void SetJoints(const Character& character, const std::vector<float>& joints,
               mjData* data) {
  mj_resetData(character.model(), data);
  for (size_t j = 0; j < joints.size(); ++j) {
    data->qpos[character.joints()[j].qpos_address] = joints[j];
  }
  // The root where the mirror's plane goes through it.
  data->qpos[0] = data->qpos[1] = data->qpos[2] = 0;
  mj_kinematics(character.model(), data);
}

// By body: its mirror partner, itself if the character names none.
std::vector<int> BodyPartners(const Character& character) {
  const mjModel* model = character.model();
  std::vector<int> partners(model->nbody);
  std::iota(partners.begin(), partners.end(), 0);
  for (const v1::MirrorPair& pair : character.proto().mirror_bodies()) {
    const int left = mj_name2id(model, mjOBJ_BODY, pair.left().c_str());
    const int right = mj_name2id(model, mjOBJ_BODY, pair.right().c_str());
    partners[left] = right;
    partners[right] = left;
  }
  return partners;
}

// Distance of a point from the mirror image of another in the plane y = 0.
double Miss(const double* a, const double* b) {
  return std::hypot(a[0] - b[0], a[1] + b[1], a[2] - b[2]);
}

}  // namespace

void Stand(const Character& character, mjData* data) {
  data->qpos[2] = character.proto().standing_root_height();
  for (const JointInfo& joint : character.joints()) {
    data->qpos[joint.qpos_address] = joint.default_position;
  }
}

void StepTowardsDefault(const Character& character, mjData* data) {
  for (const JointInfo& joint : character.joints()) {
    const double velocity = data->qvel[joint.dof_address];
    const double torque = joint.stiffness * (joint.default_position -
                                             data->qpos[joint.qpos_address]) -
                          joint.damping * velocity;
    data->qfrc_applied[joint.dof_address] =
        std::clamp(torque, -joint.torque_limit, joint.torque_limit) +
        joint.damping * velocity;
  }
  mj_step(character.model(), data);
}

double LowestSole(const Character& character, mjData* data) {
  mj_kinematics(character.model(), data);
  double lowest = INFINITY;
  for (const std::vector<int>& sole : character.foot_geoms()) {
    for (const int geom : sole) {
      lowest = std::min(lowest, Lowest(*character.model(), *data, geom));
    }
  }
  return lowest;
}

void ExpectGains(const Character& character, const GainRule& rule) {
  const std::vector<Gains> gains =
      ComputeGains(*character.model(), character.foot_bodies(), rule);
  for (const JointInfo& joint : character.joints()) {
    const Gains& expected = gains[joint.joint_id];
    EXPECT_NEAR(joint.stiffness / expected.stiffness, 1, 1e-3)
        << joint.name << " stiffness " << expected.stiffness;
    EXPECT_NEAR(joint.damping / expected.damping, 1, 1e-3)
        << joint.name << " damping " << expected.damping;
  }
}

void ExpectMirrorImage(const Character& character,
                       const MirrorTolerance& tolerance) {
  const mjModel* model = character.model();
  const auto mirror = MirrorJoints(character);
  ASSERT_TRUE(mirror.ok()) << mirror.status();
  const std::vector<int> partners = BodyPartners(character);
  const DataPtr drawn(mj_makeData(model));
  const DataPtr mirrored(mj_makeData(model));
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    const std::vector<float> joints = DrawJoints(character, seed);
    std::vector<float> image(joints.size());
    mirror->Apply(joints, absl::MakeSpan(image));
    SetJoints(character, joints, drawn.get());
    SetJoints(character, image, mirrored.get());
    for (int body = 1; body < model->nbody; ++body) {
      const int here = 3 * body;
      const int there = 3 * partners[body];
      EXPECT_LE(Miss(drawn->xpos + here, mirrored->xpos + there),
                tolerance.frames)
          << mj_id2name(model, mjOBJ_BODY, body);
      EXPECT_LE(Miss(drawn->xipos + here, mirrored->xipos + there),
                tolerance.centres)
          << mj_id2name(model, mjOBJ_BODY, body);
    }
  }
}

}  // namespace sinew::character::testing
