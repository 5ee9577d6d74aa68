// The linearisation of RefineTerms, but for its points.
#include <algorithm>
#include <utility>

#include "absl/types/span.h"
#include "sim/import/retarget/refine_terms.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;

double Square(double x) { return x * x; }

// Derivative of a displacement by the tangent coordinates of one of its ends:
// blocks for the root's place and turn, the same number for every hinge.
struct DisplacementJacobian {
  Matrix3d place, turn;
  double hinge;
};

// By its end; `seen` turns the stored frame's coordinates.
DisplacementJacobian ByEnd(const VectorXd& displacement, const Matrix3d& seen) {
  return {seen, motion::InverseRightJacobian(displacement.segment<3>(3)), 1};
}

// By the common beginning of two displacements, of their sum.
DisplacementJacobian ByBeginning(const DisplacementJacobian& a,
                                 const DisplacementJacobian& b) {
  return {-2 * Matrix3d::Identity(), -(a.turn + b.turn).transpose(), -2};
}

// block += weight * a' b.
void AddProduct(const DisplacementJacobian& a, const DisplacementJacobian& b,
                double weight, Eigen::Block<MatrixXd> block) {
  block.topLeftCorner<3, 3>() += weight * a.place.transpose() * b.place;
  block.block<3, 3>(3, 3) += weight * a.turn.transpose() * b.turn;
  block.diagonal().tail(block.rows() - 6).array() += weight * a.hinge * b.hinge;
}

void AddProduct(const DisplacementJacobian& a, const VectorXd& residual,
                Eigen::VectorBlock<VectorXd> gradient) {
  gradient.head<3>() += a.place.transpose() * residual.head<3>();
  gradient.segment<3>(3) += a.turn.transpose() * residual.segment<3>(3);
  const auto hinges = residual.size() - 6;
  gradient.tail(hinges) += a.hinge * residual.tail(hinges);
}

}  // namespace

NormalEquations RefineTerms::MakeEquations() const {
  return NormalEquations(frames_ - held_.before - held_.after, nv_,
                         /*ring=*/original_.loops);
}

void RefineTerms::Linearise(const RefineState& state,
                            NormalEquations* equations) {
  equations->Clear();
  for (int t = 0; t < frames_; ++t) {
    dynamics_->SetPose(state.motion.qpos[t]);
    NoteFeet(t);
    if (Unknown(t) >= 0) {
      AddPose(state.motion, t, equations);
      AddHeights(t, equations);
      AddSelf(t, equations);
    }
    if (!HasNeighbours(t)) continue;
    AddSmoothness(state, t, equations);
    AddPhysics(state, t, equations);
  }
  for (int t = 0; t < frames_; ++t) {
    if (HasNext(t)) AddSlip(state, t, equations);
  }
}

void RefineTerms::AddPose(const ModelMotion& motion, int t,
                          NormalEquations* equations) const {
  auto diagonal = equations->Block(Unknown(t), Unknown(t)).diagonal();
  auto gradient = equations->Gradient(Unknown(t));
  const VectorXd deviation =
      Displacement(dynamics_->model(), original_.qpos[t], motion.qpos[t]);
  const VectorXd squares = pose_weights_.cwiseAbs2();
  diagonal += squares;
  gradient += squares.cwiseProduct(deviation);
  for (const ImportJoint& joint : dynamics_->import_model().joints) {
    const double q = motion.qpos[t][joint.qpos_address];
    const double excess = q - std::clamp(q, joint.lower, joint.upper);
    if (excess == 0) continue;
    diagonal[joint.dof_address] += Square(options_.limit);
    gradient[joint.dof_address] += Square(options_.limit) * excess;
  }
}

void RefineTerms::AddSelf(int t, NormalEquations* equations) const {
  if (options_.self == 0) return;
  for (const SelfContact& contact :
       self_contacts_.Find(dynamics_->data(), self_depths_[t])) {
    const MatrixXd deeper =
        options_.self * contact.normal().transpose() *
        (dynamics_->PointJacobian(contact.body[0], contact.point[0]) -
         dynamics_->PointJacobian(contact.body[1], contact.point[1]));
    const FrameBlock block = {Unknown(t), deeper};
    equations->Add(absl::MakeConstSpan(&block, 1),
                   Eigen::Matrix<double, 1, 1>(
                       options_.self * (contact.depth - self_depths_[t])));
  }
}

void RefineTerms::AddSmoothness(const RefineState& state, int t,
                                NormalEquations* equations) const {
  const RefineState::Frame& frame = state.frames[t];
  const Neighbour next = Find(state.motion, t + 1);
  const Neighbour last = Find(state.motion, t - 1);
  struct Part {
    int unknown;
    DisplacementJacobian jacobian;
  };
  const DisplacementJacobian by_next = ByEnd(frame.after, next.turn);
  const DisplacementJacobian by_last = ByEnd(frame.before, last.turn);
  const Part parts[] = {{Unknown(last.frame), by_last},
                        {Unknown(t), ByBeginning(by_next, by_last)},
                        {Unknown(next.frame), by_next}};
  const VectorXd change = frame.after + frame.before;
  const double of_motion = Square(options_.acceleration);
  const double of_change = Square(options_.change_acceleration);
  const VectorXd pull =
      of_motion * change + of_change * (change - original_change_[t]);
  for (const Part& a : parts) {
    if (a.unknown < 0) continue;
    AddProduct(a.jacobian, pull, equations->Gradient(a.unknown));
    for (const Part& b : parts) {
      if (b.unknown < 0 || b.unknown > a.unknown) continue;
      AddProduct(a.jacobian, b.jacobian, of_motion + of_change,
                 equations->Block(a.unknown, b.unknown));
    }
  }
}

// With v = (r+ - r-) / 2 dt and a = (r+ + r-) / dt^2.
void RefineTerms::AddPhysics(const RefineState& state, int t,
                             NormalEquations* equations) {
  const RefineState::Frame& frame = state.frames[t];
  const double rate = state.motion.rate;
  const Neighbour next = Find(state.motion, t + 1);
  const Neighbour last = Find(state.motion, t - 1);
  dynamics_->Inverse((frame.after - frame.before) * (rate / 2),
                     (frame.after + frame.before) * (rate * rate));
  VectorXd residual = DifferentiateForces(frame.fit, rate);
  const DisplacementJacobian by_next = ByEnd(frame.after, next.turn);
  const DisplacementJacobian by_last = ByEnd(frame.before, last.turn);
  const int hinges = nv_ - 6;
  here_.leftCols<3>() -= next_.leftCols<3>() + last_.leftCols<3>();
  here_.middleCols<3>(3) -= next_.middleCols<3>(3) * by_next.turn.transpose() +
                            last_.middleCols<3>(3) * by_last.turn.transpose();
  here_.rightCols(hinges) -= next_.rightCols(hinges) + last_.rightCols(hinges);
  next_.leftCols<3>() *= by_next.place;
  last_.leftCols<3>() *= by_last.place;
  next_.middleCols<3>(3) *= by_next.turn;
  last_.middleCols<3>(3) *= by_last.turn;

  // Floor forces follow: the metric is (L L')^-1 on the first rows.
  const MatrixXd& factor = frame.fit.factor;
  const auto reached = factor.rows();
  std::vector<FrameBlock> blocks;
  for (const auto& [stored, jacobian] :
       {std::pair(last.frame, &last_), std::pair(t, &here_),
        std::pair(next.frame, &next_)}) {
    if (Unknown(stored) < 0) continue;
    auto rows = jacobian->topRows(reached);
    factor.triangularView<Eigen::Lower>().solveInPlace(rows);
    blocks.push_back({Unknown(stored), *jacobian});
  }
  const VectorXd first = residual.head(reached);
  residual.head(reached).noalias() =
      factor.transpose().triangularView<Eigen::Upper>() * first;
  equations->Add(blocks, residual);
}

VectorXd RefineTerms::DifferentiateForces(const ContactFit& fit, double rate) {
  const MatrixXd by_contact = ContactForceDerivative(*dynamics_, fit.forces);
  const InverseDerivatives& inverse = dynamics_->DifferentiateInverse();
  std::vector<int> order = fit.dofs;
  for (int dof = 0; dof < nv_; ++dof) {
    if (!std::binary_search(fit.dofs.begin(), fit.dofs.end(), dof)) {
      order.push_back(dof);
    }
  }
  VectorXd residual(nv_);
  for (int row = 0; row < nv_; ++row) {
    const int dof = order[row];
    const double weight = options_.physics * force_weights_[dof];
    residual[row] = weight * fit.remainder[dof];
    const auto moving = weight * rate / 2 * inverse.velocity().row(dof);
    const auto pushing = weight * rate * rate * inverse.acceleration().row(dof);
    next_.row(row) = pushing + moving;
    last_.row(row) = pushing - moving;
    here_.row(row) =
        weight * (inverse.position().row(dof) - by_contact.row(dof));
  }
  return residual;
}

}  // namespace sinew::import
