#include "sim/import/retarget/pose_terms.h"

#include <algorithm>

#include "absl/strings/match.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using Eigen::MatrixXd;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;
using RowMajor =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Overlap of bodies that is left alone, m.
constexpr double kSelfTolerance = 0.003;

bool EndsALimb(const std::string& role) {
  return absl::EndsWith(role, "_wrist") || absl::EndsWith(role, "_ankle") ||
         absl::EndsWith(role, "_toe");
}

}  // namespace

bool GoesAround(const ModelMotion& motion) {
  return motion.loops && motion.cycle.yaw == 0;
}

PoseTerms::PoseTerms(const RoleTrack& track, const BodyMap& map,
                     const ScaledSource& wanted,
                     const std::vector<std::vector<Lock>>& locks,
                     const ModelMotion& original, const PoseWindow& window,
                     Dynamics* dynamics, const PoseFitOptions& options)
    : track_(track),
      map_(map),
      wanted_(wanted),
      locks_(locks),
      original_(original),
      window_(window),
      dynamics_(dynamics),
      options_(options),
      self_contacts_(dynamics->import_model()),
      nv_(dynamics->model().nv),
      keep_weights_(VectorXd::Constant(nv_, options.hinge)),
      change_weights_(VectorXd::Constant(nv_, options.hinge_change)) {
  for (const RolePoint& point : map.points) {
    point_weights_.push_back(
        EndsALimb(track.roles[point.role]) ? options.end : options.joint);
  }
  for (const MappedBody& body : map.bodies) {
    const bool limb = !LimbParent(track.roles[body.role]).empty();
    rotation_weights_.push_back(limb ? options.limb_rotation
                                     : options.rotation);
  }
  keep_weights_.head<3>().setConstant(options.root_position);
  keep_weights_.segment<3>(3).setConstant(options.root_rotation);
  change_weights_.head<6>().setConstant(options.root_change);
}

void PoseTerms::Frame::Add(const Eigen::Ref<const MatrixXd>& jacobian,
                           const Eigen::Ref<const VectorXd>& r, double weight) {
  const double square = weight * weight;
  matrix.selfadjointView<Eigen::Lower>().rankUpdate(jacobian.transpose(),
                                                    square);
  slope.noalias() += square * (jacobian.transpose() * r);
  cost += square * r.squaredNorm();
}

void PoseTerms::Frame::AddScalar(int coordinate, double r, double weight) {
  const double square = weight * weight;
  matrix(coordinate, coordinate) += square;
  slope[coordinate] += square * r;
  cost += square * r * r;
}

void PoseTerms::AddPoints(int t, Frame* frame) const {
  for (size_t i = 0; i < map_.points.size(); ++i) {
    const RolePoint& point = map_.points[i];
    if (point.mapped == 0) continue;  // the root is kept, not pulled
    const Vector3d place = PointPlace(map_, point, *dynamics_);
    frame->Add(dynamics_->PointJacobian(map_.bodies[point.mapped].body, place),
               place - wanted_[t][point.role], point_weights_[i]);
  }
}

void PoseTerms::AddRotations(int t, Frame* frame) const {
  const mjModel& model = dynamics_->model();
  RowMajor jacobian(3, nv_);
  for (size_t i = 1; i < map_.bodies.size(); ++i) {
    const MappedBody& body = map_.bodies[i];
    const Quaterniond found =
        motion::FromWxyz(dynamics_->data().xquat + 4 * body.body);
    const Quaterniond wanted = track_.rotation[t][body.role] * body.alignment;
    const Vector3d turn = motion::Log(found * wanted.conjugate());
    mj_jacBody(&model, &dynamics_->data(), nullptr, jacobian.data(), body.body);
    frame->Add(jacobian, turn, rotation_weights_[i]);
  }
}

void PoseTerms::AddSoles(int t, Frame* frame) const {
  const std::vector<GroundPoint>& points = dynamics_->import_model().points;
  const std::vector<Vector3d> lowest = dynamics_->LowestPoints();
  std::vector<bool> stands(points.size(), false);
  for (const Lock& lock : locks_[t]) {
    stands[lock.point] = true;
    const Vector3d& place = lowest[lock.point];
    const MatrixXd jacobian = dynamics_->PointJacobian(
        points[lock.point].body,
        place + Vector3d(0, 0, points[lock.point].radius));
    frame->Add(jacobian.row(2), place.tail<1>(), options_.height);
    if (lock.slides) continue;
    frame->Add(jacobian.topRows(2), place.head<2>() - lock.place,
               options_.lock);
  }
  for (size_t i = 0; i < points.size(); ++i) {
    if (stands[i] || lowest[i].z() >= 0) continue;
    frame->Add(dynamics_->PointJacobian(points[i].body, lowest[i]).row(2),
               lowest[i].tail<1>(), options_.penetration);
  }
}

void PoseTerms::AddSelf(Frame* frame) const {
  for (const SelfContact& contact :
       self_contacts_.Find(dynamics_->data(), kSelfTolerance)) {
    const MatrixXd apart =
        contact.normal().transpose() *
        (dynamics_->PointJacobian(contact.body[1], contact.point[1]) -
         dynamics_->PointJacobian(contact.body[0], contact.point[0]));
    frame->Add(apart, Eigen::Matrix<double, 1, 1>(-contact.depth),
               options_.self);
  }
}

void PoseTerms::AddHinges(const VectorXd& qpos, const VectorXd& change,
                          Frame* frame) const {
  for (int i = 0; i < nv_; ++i) {
    frame->AddScalar(i, change[i], keep_weights_[i]);
  }
  for (const ImportJoint& joint : dynamics_->import_model().joints) {
    const double q = qpos[joint.qpos_address];
    const double excess = q - std::clamp(q, joint.lower, joint.upper);
    if (excess != 0) {
      frame->AddScalar(joint.dof_address, excess, options_.limit);
    }
  }
}

double PoseTerms::AddSmoothness(const std::vector<VectorXd>& change,
                                NormalEquations* equations) const {
  const int n = static_cast<int>(change.size());
  const VectorXd square = change_weights_.cwiseAbs2();
  const bool around = GoesAround(original_) && n == original_.frames() && n > 2;
  double cost = 0;
  for (int t = around ? 0 : 1; t < n - (around ? 0 : 1); ++t) {
    const int frames[3] = {t - 1, t, t + 1};
    const double coefficients[3] = {1, -2, 1};
    VectorXd bend = VectorXd::Zero(nv_);
    for (int i = 0; i < 3; ++i) {
      bend += coefficients[i] * change[(frames[i] + n) % n];
    }
    cost += bend.cwiseAbs2().dot(square);
    for (int i = 0; i < 3; ++i) {
      const int here = (frames[i] + n) % n;
      equations->Gradient(here) += coefficients[i] * square.cwiseProduct(bend);
      equations->Block(here, here).diagonal() +=
          coefficients[i] * coefficients[i] * square;
      // The band couples nothing over the seam of a loop.
      if (here != frames[i]) continue;
      for (int j = 0; j < i; ++j) {
        if (frames[j] < 0) continue;
        equations->Block(frames[i], frames[j]).diagonal() +=
            coefficients[i] * coefficients[j] * square;
      }
    }
  }
  return cost;
}

double PoseTerms::Linearise(const std::vector<VectorXd>& qpos, double damping,
                            NormalEquations* equations) const {
  std::vector<VectorXd> change;
  double cost = 0;
  for (int i = 0; i < window_.frames; ++i) {
    const int t = At(i);
    change.push_back(
        Displacement(dynamics_->model(), original_.qpos[t], qpos[i]));
    dynamics_->SetPose(qpos[i]);
    Frame frame{equations->Block(i, i), equations->Gradient(i)};
    AddPoints(t, &frame);
    AddRotations(t, &frame);
    AddSoles(t, &frame);
    AddSelf(&frame);
    AddHinges(qpos[i], change[i], &frame);
    frame.matrix.diagonal().array() += damping;
    cost += frame.cost;
  }
  return cost + AddSmoothness(change, equations);
}

}  // namespace sinew::import
