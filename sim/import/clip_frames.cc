#include "sim/import/clip_frames.h"

#include <algorithm>
#include <cstdint>
#include <string>

#include "common/check.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

// Rows under construction, one vector per tensor.
struct Rows {
  std::vector<float> root_position, root_rotation, root_linear_velocity,
      root_angular_velocity, joint_position, joint_velocity, body_position,
      body_rotation, body_linear_velocity, body_angular_velocity, contact,
      feedforward_torque;
};

void Append(const Vector3d& v, std::vector<float>* out) {
  for (int i = 0; i < 3; ++i) out->push_back(static_cast<float>(v[i]));
}

void Append(const Quaterniond& q, std::vector<float>* out) {
  float wxyz[4];
  motion::ToWxyz(q, wxyz);
  out->insert(out->end(), wxyz, wxyz + 4);
}

// Bodies of the state in `dynamics`; `rotations` [nbody] are those of the frame
// before, for continuity of sign (identity before the first frame, which makes
// w >= 0 there).
void AppendBodies(const Dynamics& dynamics, int root,
                  std::vector<Quaterniond>* rotations, Rows* rows) {
  const mjModel& model = dynamics.model();
  const mjData& data = dynamics.data();
  for (int b = 1; b < model.nbody; ++b) {
    Quaterniond& rotation = (*rotations)[b];
    rotation = motion::Near(motion::FromWxyz(data.xquat + 4 * b).normalized(),
                            rotation);
    const Vector3d position = Eigen::Map<const Vector3d>(data.xpos + 3 * b);
    double velocity[6];  // angular, then linear of the frame origin; world
    mj_objectVelocity(&model, &data, mjOBJ_XBODY, b, velocity,
                      /*flg_local=*/0);
    const Vector3d angular(velocity[0], velocity[1], velocity[2]);
    const Vector3d linear(velocity[3], velocity[4], velocity[5]);
    Append(position, &rows->body_position);
    Append(rotation, &rows->body_rotation);
    Append(linear, &rows->body_linear_velocity);
    Append(angular, &rows->body_angular_velocity);
    if (b != root) continue;
    Append(position, &rows->root_position);
    Append(rotation, &rows->root_rotation);
    Append(linear, &rows->root_linear_velocity);
    Append(angular, &rows->root_angular_velocity);
  }
}

void AppendJoints(const ImportModel& model, const Eigen::VectorXd& qpos,
                  const FrameDynamics& frame, Rows* rows) {
  for (size_t j = 0; j < model.joints.size(); ++j) {
    const ImportJoint& joint = model.joints[j];
    rows->joint_position.push_back(
        static_cast<float>(qpos[joint.qpos_address]));
    rows->joint_velocity.push_back(
        static_cast<float>(frame.qvel[joint.dof_address]));
    rows->feedforward_torque.push_back(static_cast<float>(
        std::clamp(frame.torque[static_cast<int>(j)], -joint.torque_limit,
                   joint.torque_limit)));
  }
  for (const bool contact : frame.contact) {
    rows->contact.push_back(contact ? 1.F : 0.F);
  }
}

TensorMap ToTensors(const Rows& rows, const ImportModel& model, int64_t n) {
  const int64_t joints = static_cast<int64_t>(model.joints.size());
  const int64_t bodies = model.model->nbody - 1;
  const int64_t feet = static_cast<int64_t>(model.feet.size());
  const auto make = [](std::vector<int64_t> shape,
                       const std::vector<float>& values) {
    return HostTensor::Float32(std::move(shape), values);
  };
  TensorMap map;
  map["root_position"] = make({n, 3}, rows.root_position);
  map["root_rotation"] = make({n, 4}, rows.root_rotation);
  map["root_linear_velocity"] = make({n, 3}, rows.root_linear_velocity);
  map["root_angular_velocity"] = make({n, 3}, rows.root_angular_velocity);
  map["joint_position"] = make({n, joints}, rows.joint_position);
  map["joint_velocity"] = make({n, joints}, rows.joint_velocity);
  map["body_position"] = make({n, bodies, 3}, rows.body_position);
  map["body_rotation"] = make({n, bodies, 4}, rows.body_rotation);
  map["body_linear_velocity"] = make({n, bodies, 3}, rows.body_linear_velocity);
  map["body_angular_velocity"] =
      make({n, bodies, 3}, rows.body_angular_velocity);
  map["contact"] = make({n, feet}, rows.contact);
  map["feedforward_torque"] = make({n, joints}, rows.feedforward_torque);
  return map;
}

}  // namespace

TensorMap MakeClipFrames(Dynamics* dynamics, const ModelMotion& motion,
                         const std::vector<FrameDynamics>& frames) {
  const mjModel& model = dynamics->model();
  const int root = model.jnt_bodyid[0];
  std::vector<Quaterniond> rotations(model.nbody, Quaterniond::Identity());
  Rows rows;
  for (int t = 0; t < motion.frames(); ++t) {
    dynamics->SetState(motion.qpos[t], frames[t].qvel);
    AppendBodies(*dynamics, root, &rotations, &rows);
    AppendJoints(dynamics->import_model(), motion.qpos[t], frames[t], &rows);
  }
  return ToTensors(rows, dynamics->import_model(), motion.frames());
}

void AppendFrames(const TensorMap& clip, TensorMap* library) {
  if (library->empty()) {
    *library = clip;
    return;
  }
  for (const auto& [name, tensor] : clip) {
    const auto found = library->find(name);
    SINEW_CHECK(found != library->end()) << "no tensor " << name;
    found->second.shape[0] += tensor.shape[0];
    found->second.data += tensor.data;
  }
}

}  // namespace sinew::import
