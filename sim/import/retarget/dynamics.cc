#include "sim/import/retarget/dynamics.h"

#include <algorithm>

#include "common/check.h"

namespace sinew::import {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using RowMajor =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Step of the finite differences.
constexpr double kEpsilon = 1e-6;

}  // namespace

Dynamics::Dynamics(const ImportModel& import_model)
    : import_model_(import_model),
      model_(mj_copyModel(nullptr, import_model.model)) {
  SINEW_CHECK(model_ != nullptr) << "MuJoCo could not copy the model";
  model_->opt.disableflags |=
      mjDSBL_CONSTRAINT | mjDSBL_ACTUATION | mjDSBL_SENSOR | mjDSBL_DAMPER;
  data_.reset(mj_makeData(model_.get()));
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
  std::vector<Vector3d> lowest;
  for (const GroundPoint& point : import_model_.points) {
    lowest.push_back(Lowest(point, *data_));
  }
  return lowest;
}

MatrixXd Dynamics::PointJacobian(int body, const Vector3d& point) const {
  RowMajor jacobian(3, model_->nv);
  mj_jac(model_.get(), data_.get(), jacobian.data(), nullptr, point.data(),
         body);
  return jacobian;
}

Vector3d Dynamics::CentreOfMass() const {
  return Eigen::Map<const Vector3d>(data_->subtree_com);
}

void Dynamics::SetAll(const VectorXd& qpos, const VectorXd& qvel,
                      const VectorXd& qacc) {
  std::copy_n(qpos.data(), model_->nq, data_->qpos);
  std::copy_n(qvel.data(), model_->nv, data_->qvel);
  std::copy_n(qacc.data(), model_->nv, data_->qacc);
  mj_inverse(model_.get(), data_.get());
}

VectorXd Dynamics::Inverse(const VectorXd& qpos, const VectorXd& qvel,
                           const VectorXd& qacc) {
  SetAll(qpos, qvel, qacc);
  return Eigen::Map<const VectorXd>(data_->qfrc_inverse, model_->nv);
}

Dynamics::Derivatives Dynamics::InverseDerivatives(const VectorXd& qpos,
                                                   const VectorXd& qvel,
                                                   const VectorXd& qacc) {
  SetAll(qpos, qvel, qacc);
  const int nv = model_->nv;
  // MuJoCo stores one row per coordinate: the transpose of what we return.
  RowMajor q(nv, nv), v(nv, nv), a(nv, nv);
  mjd_inverseFD(model_.get(), data_.get(), kEpsilon, /*flg_actuation=*/0,
                q.data(), v.data(), a.data(), nullptr, nullptr, nullptr,
                nullptr);
  return {q.transpose(), v.transpose(), a.transpose()};
}

}  // namespace sinew::import
