#include "sim/import/retarget/dynamics.h"

#include <algorithm>
#include <cmath>

#include "common/check.h"

namespace sinew::import {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

character::ModelPtr CopyModel(const mjModel* model) {
  character::ModelPtr copy(mj_copyModel(nullptr, model));
  SINEW_CHECK(copy != nullptr) << "MuJoCo could not copy the model";
  copy->opt.disableflags |=
      mjDSBL_CONSTRAINT | mjDSBL_ACTUATION | mjDSBL_SENSOR | mjDSBL_DAMPER;
  return copy;
}

std::vector<std::vector<int>> MakeChains(const mjModel& model) {
  std::vector<std::vector<int>> chains(model.nbody);
  for (int body = 1; body < model.nbody; ++body) {
    chains[body] = chains[model.body_parentid[body]];
    for (int i = 0; i < model.body_dofnum[body]; ++i) {
      chains[body].push_back(model.body_dofadr[body] + i);
    }
  }
  return chains;
}

}  // namespace

Dynamics::Dynamics(const ImportModel& import_model)
    : import_model_(import_model),
      model_(CopyModel(import_model.model)),
      data_(mj_makeData(model_.get())),
      chains_(MakeChains(*model_)),
      derivatives_(*model_) {
  SINEW_CHECK(data_ != nullptr) << "MuJoCo could not make data";
}

void Dynamics::SetPose(const VectorXd& qpos) {
  std::copy_n(qpos.data(), model_->nq, data_->qpos);
  mj_kinematics(model_.get(), data_.get());
  mj_comPos(model_.get(), data_.get());
}

void Dynamics::SetState(const VectorXd& qpos, const VectorXd& qvel) {
  SetPose(qpos);
  std::copy_n(qvel.data(), model_->nv, data_->qvel);
  mj_comVel(model_.get(), data_.get());
}

std::vector<Vector3d> Dynamics::LowestPoints() const {
  const int count = static_cast<int>(import_model_.points.size());
  std::vector<Vector3d> lowest;
  lowest.reserve(count);
  for (int i = 0; i < count; ++i) lowest.push_back(LowestPoint(i));
  return lowest;
}

Vector3d Dynamics::LowestPoint(int index) const {
  const GroundPoint& point = import_model_.points[index];
  Vector3d position =
      Eigen::Map<const RowMajor3>(data_->xmat + 9 * point.body) *
          point.position +
      Eigen::Map<const Vector3d>(data_->xpos + 3 * point.body);
  position.z() -= point.radius;
  return position;
}

double Dynamics::Height(int index) const {
  const GroundPoint& point = import_model_.points[index];
  return Eigen::Map<const Vector3d>(data_->xmat + 9 * point.body + 6)
             .dot(point.position) +
         data_->xpos[3 * point.body + 2] - point.radius;
}

double Dynamics::LowestHeight() const {
  double lowest = INFINITY;
  for (size_t i = 0; i < import_model_.points.size(); ++i) {
    lowest = std::min(lowest, Height(static_cast<int>(i)));
  }
  return lowest;
}

MatrixXd Dynamics::PointJacobian(int body, const Vector3d& point) const {
  const Vector3d arm = point - Pivot();
  MatrixXd jacobian = MatrixXd::Zero(3, model_->nv);
  for (const int dof : chains_[body]) {
    const Vector6 axis = Axis(dof);
    jacobian.col(dof) = axis.head<3>().cross(arm) + axis.tail<3>();
  }
  return jacobian;
}

Vector3d Dynamics::CentreOfMass() const {
  return Eigen::Map<const Vector3d>(data_->subtree_com);
}

Vector3d Dynamics::Pivot() const {
  const int root = model_->jnt_bodyid[0];
  return Eigen::Map<const Vector3d>(data_->subtree_com +
                                    3 * model_->body_rootid[root]);
}

VectorXd Dynamics::Inverse(const VectorXd& qpos, const VectorXd& qvel,
                           const VectorXd& qacc) {
  SetPose(qpos);
  return Inverse(qvel, qacc);
}

VectorXd Dynamics::Inverse(const VectorXd& qvel, const VectorXd& qacc) {
  std::copy_n(qvel.data(), model_->nv, data_->qvel);
  std::copy_n(qacc.data(), model_->nv, data_->qacc);
  if (model_->ntendon > 0) mj_tendon(model_.get(), data_.get());
  mj_comVel(model_.get(), data_.get());
  mj_passive(model_.get(), data_.get());
  VectorXd force(model_->nv);
  mj_rne(model_.get(), data_.get(), /*flg_acc=*/1, force.data());
  for (int i = 0; i < model_->nv; ++i) {
    force[i] +=
        model_->dof_armature[i] * data_->qacc[i] - data_->qfrc_passive[i];
  }
  return force;
}

const InverseDerivatives& Dynamics::DifferentiateInverse() {
  derivatives_.Compute(*data_);
  return derivatives_;
}

}  // namespace sinew::import
