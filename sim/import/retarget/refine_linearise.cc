// The linearisation of RefineTerms.
#include <algorithm>
#include <cmath>

#include "sim/import/retarget/refine_terms.h"
#include "sim/import/retarget/spatial.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Axes = Eigen::Matrix<double, 6, Eigen::Dynamic>;
using Matrix26 = Eigen::Matrix<double, 2, 6>;

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

// block(rows, columns) += matrix.
void Scatter(const MatrixXd& matrix, const std::vector<int>& rows,
             const std::vector<int>& columns, Eigen::Block<MatrixXd> block) {
  for (size_t j = 0; j < columns.size(); ++j) {
    for (size_t i = 0; i < rows.size(); ++i) {
      block(rows[i], columns[j]) +=
          matrix(static_cast<int>(i), static_cast<int>(j));
    }
  }
}

void Scatter(const VectorXd& vector, const std::vector<int>& rows,
             Eigen::VectorBlock<VectorXd> gradient) {
  for (size_t i = 0; i < rows.size(); ++i) {
    gradient[rows[i]] += vector[static_cast<int>(i)];
  }
}

Axes ChainAxes(const Dynamics& dynamics, int body) {
  const std::vector<int>& chain = dynamics.Chain(body);
  Axes axes(6, static_cast<int>(chain.size()));
  for (size_t i = 0; i < chain.size(); ++i) {
    axes.col(static_cast<int>(i)) = dynamics.Axis(chain[i]);
  }
  return axes;
}

// Horizontal velocity of a point that moves with a motion vector.
Matrix26 Horizontal(const Vector3d& arm) {
  Matrix26 jacobian;
  jacobian << 0, arm.z(), -arm.y(), 1, 0, 0, -arm.z(), 0, arm.x(), 0, 1, 0;
  return jacobian;
}

// Terms of points of one body that are quadratic in how the body moves.
struct BodyTerms {
  bool any = false;
  Matrix6 matrix = Matrix6::Zero();
  Vector6 gradient = Vector6::Zero();
};

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
    }
    if (!HasNeighbours(t)) continue;
    AddSmoothness(state, t, equations);
    AddPhysics(state, t, equations);
  }
  for (int t = 0; t < frames_; ++t) {
    if (HasNext(t)) AddSlip(state, t, equations);
  }
}

void RefineTerms::NoteFeet(int t) {
  FeetMoves& moves = feet_moves_[t];
  moves.pivot = dynamics_->Pivot();
  moves.axes.clear();
  for (const int foot : dynamics_->import_model().feet) {
    moves.axes.push_back(soles_[t].empty() ? Axes()
                                           : ChainAxes(*dynamics_, foot));
  }
}

void RefineTerms::AddPose(const ModelMotion& motion, int t,
                          NormalEquations* equations) const {
  const mjModel& model = dynamics_->model();
  auto diagonal = equations->Block(Unknown(t), Unknown(t)).diagonal();
  auto gradient = equations->Gradient(Unknown(t));
  VectorXd deviation(nv_);
  mj_differentiatePos(&model, deviation.data(), 1, original_.qpos[t].data(),
                      motion.qpos[t].data());
  const VectorXd squares = pose_weights_.cwiseAbs2();
  diagonal += squares;
  gradient += squares.cwiseProduct(deviation);
  for (const ImportJoint& joint : dynamics_->import_model().joints) {
    const int id = model.dof_jntid[joint.dof_address];
    if (!model.jnt_limited[id]) continue;
    const double q = motion.qpos[t][joint.qpos_address];
    const double excess =
        q - std::clamp(q, model.jnt_range[2 * id], model.jnt_range[2 * id + 1]);
    if (excess == 0) continue;
    diagonal[joint.dof_address] += Square(options_.limit);
    gradient[joint.dof_address] += Square(options_.limit) * excess;
  }
}

// A point's height follows the centre of its ball.
void RefineTerms::AddHeights(int t, NormalEquations* equations) const {
  const ImportModel& model = dynamics_->import_model();
  const Vector3d pivot = dynamics_->Pivot();
  std::vector<BodyTerms> bodies(model.model->nbody);
  for (int i = 0; i < static_cast<int>(model.points.size()); ++i) {
    const double height = dynamics_->Height(i);
    const double square =
        (bearing_[t][i] ? Square(options_.contact_height) : 0) +
        (height < 0 ? Square(options_.penetration) : 0);
    if (square == 0) continue;
    const GroundPoint& point = model.points[i];
    const Vector3d arm =
        dynamics_->LowestPoint(i) + Vector3d(0, 0, point.radius) - pivot;
    const Vector6 row =
        MakeVector6(arm.cross(Vector3d::UnitZ()), Vector3d::UnitZ());
    BodyTerms& body = bodies[point.body];
    body.any = true;
    body.matrix += square * row * row.transpose();
    body.gradient += square * height * row;
  }
  for (int b = 0; b < static_cast<int>(bodies.size()); ++b) {
    if (!bodies[b].any) continue;
    const std::vector<int>& chain = dynamics_->Chain(b);
    const Axes axes = ChainAxes(*dynamics_, b);
    const int unknown = Unknown(t);
    Scatter(axes.transpose() * bodies[b].matrix * axes, chain, chain,
            equations->Block(unknown, unknown));
    Scatter(axes.transpose() * bodies[b].gradient, chain,
            equations->Gradient(unknown));
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

// With v = (r+ - r-) / 2 dt and a = (r+ + r-) / dt^2; rows in the order that
// has those first which floor forces reach.
void RefineTerms::AddPhysics(const RefineState& state, int t,
                             NormalEquations* equations) {
  const RefineState::Frame& frame = state.frames[t];
  const ContactFit& fit = frame.fit;
  const double rate = state.motion.rate;
  const MatrixXd by_contact = ContactForceDerivative(*dynamics_, fit.forces);
  dynamics_->Inverse((frame.after - frame.before) * (rate / 2),
                     (frame.after + frame.before) * (rate * rate));
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
  const Neighbour next = Find(state.motion, t + 1);
  const Neighbour last = Find(state.motion, t - 1);
  const DisplacementJacobian by_next = ByEnd(frame.after, next.turn);
  const DisplacementJacobian by_last = ByEnd(frame.before, last.turn);
  here_.leftCols<3>() -= next_.leftCols<3>() + last_.leftCols<3>();
  here_.middleCols<3>(3) -= next_.middleCols<3>(3) * by_next.turn.transpose() +
                            last_.middleCols<3>(3) * by_last.turn.transpose();
  here_.rightCols(nv_ - 6) -=
      next_.rightCols(nv_ - 6) + last_.rightCols(nv_ - 6);
  next_.leftCols<3>() *= by_next.place;
  last_.leftCols<3>() *= by_last.place;
  next_.middleCols<3>(3) *= by_next.turn;
  last_.middleCols<3>(3) *= by_last.turn;

  // Forces follow: the metric is (L L')^-1 on the first rows.
  const int reached = static_cast<int>(fit.dofs.size());
  std::vector<FrameBlock> blocks;
  for (const auto& [stored, jacobian] :
       {std::pair(last.frame, &last_), std::pair(t, &here_),
        std::pair(next.frame, &next_)}) {
    if (Unknown(stored) < 0) continue;
    auto rows = jacobian->topRows(reached);
    fit.factor.triangularView<Eigen::Lower>().solveInPlace(rows);
    blocks.push_back({Unknown(stored), *jacobian});
  }
  residual.head(reached) =
      (fit.factor.transpose().triangularView<Eigen::Upper>() *
       residual.head(reached))
          .eval();
  equations->Add(blocks, residual);
}

void RefineTerms::AddSlip(const RefineState& state, int t,
                          NormalEquations* equations) const {
  const ImportModel& model = dynamics_->import_model();
  const Neighbour next = Find(state.motion, t + 1);
  const int unknowns[] = {Unknown(t), Unknown(next.frame)};
  const FeetMoves* const moves[] = {&feet_moves_[t], &feet_moves_[next.frame]};
  struct Pair {
    bool any = false;
    Matrix6 here = Matrix6::Zero(), both = here, there = here;
    Vector6 pull_here = Vector6::Zero(), pull_there = pull_here;
  };
  std::vector<Pair> feet(model.feet.size());
  VisitSlips(soles_[t], soles_[next.frame], [&](size_t a, size_t b) {
    const GroundPoint& point = model.points[soles_[t][a]];
    const auto foot =
        std::find(model.feet.begin(), model.feet.end(), point.body) -
        model.feet.begin();
    const Vector3d up(0, 0, point.radius);
    const Vector3d from = state.frames[t].soles[a];
    const Vector3d to = state.frames[next.frame].soles[b];
    const Matrix26 here = -Horizontal(from + up - moves[0]->pivot);
    const Matrix26 there =
        next.turn.topLeftCorner<2, 2>() * Horizontal(to + up - moves[1]->pivot);
    const Eigen::Vector2d slip =
        (Seen(state.motion, t + 1, to) - from).head<2>();
    Pair& pair = feet[foot];
    pair.any = true;
    pair.here += here.transpose() * here;
    pair.both += there.transpose() * here;
    pair.there += there.transpose() * there;
    pair.pull_here += here.transpose() * slip;
    pair.pull_there += there.transpose() * slip;
  });
  const double square = Square(options_.contact_slip);
  for (size_t f = 0; f < feet.size(); ++f) {
    if (!feet[f].any) continue;
    const std::vector<int>& chain = dynamics_->Chain(model.feet[f]);
    const Axes& here = moves[0]->axes[f];
    const Axes& there = moves[1]->axes[f];
    const auto add = [&](const Axes& axes, const Matrix6& matrix,
                         const Vector6& pull, int unknown) {
      if (unknown < 0) return;
      Scatter(square * axes.transpose() * matrix * axes, chain, chain,
              equations->Block(unknown, unknown));
      Scatter(square * axes.transpose() * pull, chain,
              equations->Gradient(unknown));
    };
    add(here, feet[f].here, feet[f].pull_here, unknowns[0]);
    add(there, feet[f].there, feet[f].pull_there, unknowns[1]);
    if (unknowns[0] < 0 || unknowns[1] < 0) continue;
    const MatrixXd both = square * there.transpose() * feet[f].both * here;
    if (unknowns[1] > unknowns[0]) {
      Scatter(both, chain, chain, equations->Block(unknowns[1], unknowns[0]));
    } else {
      Scatter(both.transpose(), chain, chain,
              equations->Block(unknowns[0], unknowns[1]));
    }
  }
}

}  // namespace sinew::import
