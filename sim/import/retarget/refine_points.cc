// The linearisation of RefineTerms: points that bear, sink or slip.
#include <vector>

#include "sim/import/retarget/refine_terms.h"
#include "sim/import/retarget/spatial.h"

namespace sinew::import {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Axes = Eigen::Matrix<double, 6, Eigen::Dynamic>;
using Matrix26 = Eigen::Matrix<double, 2, 6>;

double Square(double x) { return x * x; }

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

// Slips of one foot's points from one frame to the next, as quadratic in how
// the foot moves in both.
struct FootTerms {
  bool any = false;
  Matrix6 here = Matrix6::Zero(), both = here, there = here;
  Vector6 pull_here = Vector6::Zero(), pull_there = pull_here;
};

// Terms of points of one body that are quadratic in how the body moves.
struct BodyTerms {
  bool any = false;
  Matrix6 matrix = Matrix6::Zero();
  Vector6 gradient = Vector6::Zero();
};

// The chain moves the foot by `here` and `there` in its two frames, which are
// unknowns unless negative.
void AddFoot(const FootTerms& terms, const std::vector<int>& chain,
             const Axes& here, const Axes& there, double square,
             int unknown_here, int unknown_there, NormalEquations* equations) {
  const auto add = [&](const Axes& axes, const Matrix6& matrix,
                       const Vector6& pull, int unknown) {
    if (unknown < 0) return;
    Scatter(square * axes.transpose() * matrix * axes, chain, chain,
            equations->Block(unknown, unknown));
    Scatter(square * axes.transpose() * pull, chain,
            equations->Gradient(unknown));
  };
  add(here, terms.here, terms.pull_here, unknown_here);
  add(there, terms.there, terms.pull_there, unknown_there);
  if (unknown_here < 0 || unknown_there < 0) return;
  const MatrixXd both = square * there.transpose() * terms.both * here;
  if (unknown_there > unknown_here) {
    Scatter(both, chain, chain, equations->Block(unknown_there, unknown_here));
  } else {
    Scatter(both.transpose(), chain, chain,
            equations->Block(unknown_here, unknown_there));
  }
}

}  // namespace

void RefineTerms::NoteFeet(int t) {
  FeetMoves& moves = feet_moves_[t];
  moves.pivot = dynamics_->Pivot();
  moves.axes.clear();
  for (const int foot : dynamics_->import_model().feet) {
    moves.axes.push_back(soles_[t].empty() ? Axes()
                                           : ChainAxes(*dynamics_, foot));
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

void RefineTerms::AddSlip(const RefineState& state, int t,
                          NormalEquations* equations) const {
  const ImportModel& model = dynamics_->import_model();
  const Neighbour next = Find(state.motion, t + 1);
  const FeetMoves& here = feet_moves_[t];
  const FeetMoves& there = feet_moves_[next.frame];
  std::vector<FootTerms> feet(model.feet.size());
  VisitSlips(soles_[t], soles_[next.frame], [&](size_t a, size_t b) {
    const int point = soles_[t][a];
    const Vector3d up(0, 0, model.points[point].radius);
    const Vector3d from = state.frames[t].soles[a];
    const Vector3d to = state.frames[next.frame].soles[b];
    const Matrix26 by_here = -Horizontal(from + up - here.pivot);
    const Matrix26 by_there =
        next.turn.topLeftCorner<2, 2>() * Horizontal(to + up - there.pivot);
    const Eigen::Vector2d slip =
        (Seen(state.motion, t + 1, to) - from).head<2>();
    FootTerms& terms = feet[model.FootOf(point)];
    terms.any = true;
    terms.here += by_here.transpose() * by_here;
    terms.both += by_there.transpose() * by_here;
    terms.there += by_there.transpose() * by_there;
    terms.pull_here += by_here.transpose() * slip;
    terms.pull_there += by_there.transpose() * slip;
  });
  for (size_t f = 0; f < feet.size(); ++f) {
    if (!feet[f].any) continue;
    const std::vector<int>& chain = dynamics_->Chain(model.feet[f]);
    AddFoot(feet[f], chain, here.axes[f], there.axes[f],
            Square(options_.contact_slip), Unknown(t), Unknown(next.frame),
            equations);
  }
}

}  // namespace sinew::import
