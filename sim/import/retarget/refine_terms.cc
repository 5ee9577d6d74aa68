#include "sim/import/retarget/refine_terms.h"

#include <algorithm>
#include <cmath>

#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Points higher than this are left out of the search for bearing points.
constexpr double kReach = 0.03;

double Square(double x) { return x * x; }

VectorXd Displacement(const mjModel& model, const VectorXd& a,
                      const VectorXd& b) {
  VectorXd difference(model.nv);
  mj_differentiatePos(&model, difference.data(), 1, a.data(), b.data());
  return difference;
}

// Derivatives of Displacement(a, b) by the tangent coordinates of its ends.
struct DisplacementJacobians {
  MatrixXd begin, end;  // [nv, nv]
};

DisplacementJacobians Differentiate(const VectorXd& displacement) {
  const int nv = static_cast<int>(displacement.size());
  const Matrix3d rotation =
      motion::InverseRightJacobian(displacement.segment<3>(3));
  DisplacementJacobians jacobians{-MatrixXd::Identity(nv, nv),
                                  MatrixXd::Identity(nv, nv)};
  jacobians.end.block<3, 3>(3, 3) = rotation;
  jacobians.begin.block<3, 3>(3, 3) = -rotation.transpose();
  return jacobians;
}

// Columns of the root's translation as the stored frame knows them.
MatrixXd Turned(MatrixXd jacobian, const Matrix3d& turn) {
  jacobian.leftCols<3>() = (jacobian.leftCols<3>() * turn).eval();
  return jacobian;
}

VectorXd PerCoordinate(int nv, double floor, double up, double rotation,
                       double joint) {
  VectorXd weights = VectorXd::Constant(nv, joint);
  weights.head<2>().setConstant(floor);
  weights[2] = up;
  weights.segment<3>(3).setConstant(rotation);
  return weights;
}

}  // namespace

RefineTerms::RefineTerms(Dynamics* dynamics, const ModelMotion& original,
                         const std::vector<std::vector<bool>>& bearing,
                         const RefineOptions& options)
    : dynamics_(dynamics),
      original_(original),
      bearing_(bearing),
      options_(options),
      frames_(original.frames()),
      nv_(dynamics->model().nv),
      pose_weights_(PerCoordinate(nv_, options.position, options.height,
                                  options.rotation, options.joint)),
      original_change_(frames_),
      may_bear_(frames_) {
  for (int t = 0; t < frames_; ++t) {
    if (HasNeighbours(t)) original_change_[t] = SecondDifference(original, t);
  }
}

void RefineTerms::ChooseContacts(const ModelMotion& motion) {
  for (int t = 0; t < frames_; ++t) {
    dynamics_->SetPose(motion.qpos[t]);
    may_bear_[t].clear();
    for (const Contact& contact : FindContacts(*dynamics_, kReach)) {
      may_bear_[t].push_back(contact.point);
    }
  }
}

double RefineTerms::Cost(const ModelMotion& motion) const {
  double cost = 0;
  VectorXd qvel;
  VectorXd qacc;
  for (int t = 0; t < frames_; ++t) {
    cost += PoseCost(motion, t) + PointCost(motion, t);
    if (!HasNeighbours(t)) continue;
    const VectorXd change = SecondDifference(motion, t);
    cost += Square(options_.acceleration) * change.squaredNorm() +
            Square(options_.change_acceleration) *
                (change - original_change_[t]).squaredNorm();
    cost += Square(options_.physics) *
            Contacts(motion, t, &qvel, &qacc).cost;
  }
  return cost;
}

NormalEquations RefineTerms::Linearise(const ModelMotion& motion) const {
  NormalEquations equations(frames_, nv_);
  for (int t = 0; t < frames_; ++t) {
    AddPose(motion, t, &equations);
    AddPoints(motion, t, &equations);
    AddSlip(motion, t, &equations);
    if (!HasNeighbours(t)) continue;
    AddSmoothness(motion, t, &equations);
    AddPhysics(motion, t, &equations);
  }
  return equations;
}

RefineTerms::Neighbour RefineTerms::Find(const ModelMotion& motion,
                                         int t) const {
  const int frame = (t + frames_) % frames_;
  const double yaw =
      t < 0 ? -motion.cycle.yaw : (t >= frames_ ? motion.cycle.yaw : 0);
  return {frame, motion::YawRotation(yaw).toRotationMatrix()};
}

bool RefineTerms::HasNeighbours(int t) const {
  return original_.loops || (t > 0 && t + 1 < frames_);
}

VectorXd RefineTerms::Deviation(const ModelMotion& motion, int t) const {
  return Displacement(dynamics_->model(), original_.qpos[t], motion.qpos[t]);
}

VectorXd RefineTerms::SecondDifference(const ModelMotion& motion,
                                       int t) const {
  const mjModel& model = dynamics_->model();
  return Displacement(model, motion.qpos[t], FrameAt(motion, t + 1)) +
         Displacement(model, motion.qpos[t], FrameAt(motion, t - 1));
}

ContactFit RefineTerms::Contacts(const ModelMotion& motion, int t,
                                 VectorXd* qvel, VectorXd* qacc) const {
  Rates(dynamics_->model(), motion, t, qvel, qacc);
  const VectorXd required =
      dynamics_->Inverse(motion.qpos[t], *qvel, *qacc);
  std::vector<Contact> contacts;
  for (const int point : may_bear_[t]) {
    contacts.push_back(
        {point, Lowest(dynamics_->import_model().points[point],
                       dynamics_->data())});
  }
  return FitContacts(*dynamics_, contacts, required, options_.torque);
}

bool RefineTerms::Bears(int t, size_t point) const {
  return bearing_[(t + frames_) % frames_][point];
}

double RefineTerms::PoseCost(const ModelMotion& motion, int t) const {
  const mjModel& model = dynamics_->model();
  double cost =
      Deviation(motion, t).cwiseProduct(pose_weights_).squaredNorm();
  for (const ImportJoint& joint : dynamics_->import_model().joints) {
    const int id = model.dof_jntid[joint.dof_address];
    if (!model.jnt_limited[id]) continue;
    const double q = motion.qpos[t][joint.qpos_address];
    const double excess = q - std::clamp(q, model.jnt_range[2 * id],
                                         model.jnt_range[2 * id + 1]);
    cost += Square(options_.limit * excess);
  }
  return cost;
}

double RefineTerms::PointCost(const ModelMotion& motion, int t) const {
  const ImportModel& model = dynamics_->import_model();
  dynamics_->SetPose(motion.qpos[t]);
  const std::vector<Vector3d> here = dynamics_->LowestPoints();
  double cost = 0;
  for (size_t i = 0; i < here.size(); ++i) {
    if (Bears(t, i)) cost += Square(options_.contact_height * here[i].z());
    cost += Square(options_.penetration * std::min(0.0, here[i].z()));
  }
  if (!original_.loops && t + 1 == frames_) return cost;
  dynamics_->SetPose(FrameAt(motion, t + 1));
  for (const int foot : model.feet) {
    for (size_t i = 0; i < here.size(); ++i) {
      if (model.points[i].body != foot) continue;
      if (!Bears(t, i) || !Bears(t + 1, i)) continue;
      const Vector3d there = Lowest(model.points[i], dynamics_->data());
      cost += Square(options_.contact_slip) *
              (there - here[i]).head<2>().squaredNorm();
    }
  }
  return cost;
}

void RefineTerms::AddPose(const ModelMotion& motion, int t,
                          NormalEquations* equations) const {
  const mjModel& model = dynamics_->model();
  const VectorXd deviation = Deviation(motion, t);
  for (int i = 0; i < nv_; ++i) {
    equations->AddScalar(t, i, pose_weights_[i], deviation[i]);
  }
  for (const ImportJoint& joint : dynamics_->import_model().joints) {
    const int id = model.dof_jntid[joint.dof_address];
    if (!model.jnt_limited[id]) continue;
    const double q = motion.qpos[t][joint.qpos_address];
    const double excess = q - std::clamp(q, model.jnt_range[2 * id],
                                         model.jnt_range[2 * id + 1]);
    if (excess == 0) continue;
    equations->AddScalar(t, joint.dof_address, options_.limit, excess);
  }
}

void RefineTerms::AddPoints(const ModelMotion& motion, int t,
                            NormalEquations* equations) const {
  const ImportModel& model = dynamics_->import_model();
  dynamics_->SetPose(motion.qpos[t]);
  const std::vector<Vector3d> lowest = dynamics_->LowestPoints();
  for (size_t i = 0; i < lowest.size(); ++i) {
    const double height = lowest[i].z();
    const double square =
        (Bears(t, i) ? Square(options_.contact_height) : 0) +
        (height < 0 ? Square(options_.penetration) : 0);
    if (square == 0) continue;
    const double weight = std::sqrt(square);
    const MatrixXd jacobian = dynamics_->PointJacobian(
        model.points[i].body,
        lowest[i] + Vector3d(0, 0, model.points[i].radius));
    equations->Add({{t, weight * jacobian.row(2)}},
                   VectorXd::Constant(1, weight * height));
  }
}

void RefineTerms::AddSlip(const ModelMotion& motion, int t,
                          NormalEquations* equations) const {
  if (!original_.loops && t + 1 == frames_) return;
  const ImportModel& model = dynamics_->import_model();
  struct Sample {
    size_t point;
    Vector3d position;
    MatrixXd jacobian;
  };
  const auto sample = [&](const VectorXd& qpos) {
    dynamics_->SetPose(qpos);
    std::vector<Sample> samples;
    for (const int foot : model.feet) {
      for (size_t i = 0; i < model.points.size(); ++i) {
        const GroundPoint& point = model.points[i];
        if (point.body != foot || !Bears(t, i) || !Bears(t + 1, i)) continue;
        const Vector3d position = Lowest(point, dynamics_->data());
        samples.push_back(
            {i, position,
             dynamics_->PointJacobian(
                 foot, position + Vector3d(0, 0, point.radius))});
      }
    }
    return samples;
  };
  const std::vector<Sample> here = sample(motion.qpos[t]);
  const std::vector<Sample> there = sample(FrameAt(motion, t + 1));
  const Neighbour next = Find(motion, t + 1);
  for (size_t k = 0; k < here.size(); ++k) {
    const double weight = options_.contact_slip;
    equations->Add(
        {{t, -weight * here[k].jacobian.topRows<2>()},
         {next.frame,
          weight * Turned(there[k].jacobian, next.turn).topRows<2>()}},
        weight * (there[k].position - here[k].position).head<2>());
  }
}

void RefineTerms::AddSmoothness(const ModelMotion& motion, int t,
                                NormalEquations* equations) const {
  const mjModel& model = dynamics_->model();
  const VectorXd after =
      Displacement(model, motion.qpos[t], FrameAt(motion, t + 1));
  const VectorXd before =
      Displacement(model, motion.qpos[t], FrameAt(motion, t - 1));
  const DisplacementJacobians d_after = Differentiate(after);
  const DisplacementJacobians d_before = Differentiate(before);
  const Neighbour next = Find(motion, t + 1);
  const Neighbour last = Find(motion, t - 1);
  const MatrixXd here = d_after.begin + d_before.begin;
  const MatrixXd there = Turned(d_after.end, next.turn);
  const MatrixXd then = Turned(d_before.end, last.turn);
  const auto add = [&](double weight, const VectorXd& residual) {
    equations->Add({{t, weight * here},
                    {next.frame, weight * there},
                    {last.frame, weight * then}},
                   weight * residual);
  };
  add(options_.acceleration, after + before);
  add(options_.change_acceleration, after + before - original_change_[t]);
}

void RefineTerms::AddPhysics(const ModelMotion& motion, int t,
                             NormalEquations* equations) const {
  const mjModel& model = dynamics_->model();
  VectorXd qvel;
  VectorXd qacc;
  const ContactFit fit = Contacts(motion, t, &qvel, &qacc);
  const MatrixXd by_contact = ContactForceDerivative(*dynamics_, fit.forces);
  const Dynamics::Derivatives inverse =
      dynamics_->InverseDerivatives(motion.qpos[t], qvel, qacc);
  const DisplacementJacobians after = Differentiate(
      Displacement(model, motion.qpos[t], FrameAt(motion, t + 1)));
  const DisplacementJacobians before = Differentiate(
      Displacement(model, motion.qpos[t], FrameAt(motion, t - 1)));

  // v = (r+ - r-) / 2 dt, a = (r+ + r-) / dt^2.
  const double rate = motion.rate;
  const VectorXd weights =
      options_.physics *
      ContactFitWeights(dynamics_->import_model(), options_.torque);
  const MatrixXd by_position =
      weights.asDiagonal() * (inverse.position - by_contact);
  const MatrixXd by_velocity =
      weights.asDiagonal() * inverse.velocity * (rate / 2);
  const MatrixXd by_acceleration =
      weights.asDiagonal() * inverse.acceleration * (rate * rate);
  const Neighbour next = Find(motion, t + 1);
  const Neighbour last = Find(motion, t - 1);
  equations->Add(
      {{t, by_position + by_velocity * (after.begin - before.begin) +
               by_acceleration * (after.begin + before.begin)},
       {next.frame,
        Turned((by_velocity + by_acceleration) * after.end, next.turn)},
       {last.frame,
        Turned((by_acceleration - by_velocity) * before.end, last.turn)}},
      weights.cwiseProduct(fit.remainder), fit.sensitivity);
}

}  // namespace sinew::import
