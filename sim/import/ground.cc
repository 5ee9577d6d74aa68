#include "sim/import/ground.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

#include "sim/import/contact_fit.h"

namespace sinew::import {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

// What one frame says about the floor.
struct FrameState {
  std::vector<Vector3d> lowest;  // [points]
  std::vector<double> speed;     // [points] of the material point, m/s
  Vector3d centre;               // of mass
  int lowest_point = 0;

  double low() const { return lowest[lowest_point].z(); }
};

std::vector<FrameState> MeasureFrames(Dynamics* dynamics,
                                      const ModelMotion& motion) {
  const std::vector<GroundPoint>& points = dynamics->import_model().points;
  std::vector<FrameState> frames(motion.frames());
  VectorXd qvel;
  VectorXd qacc;
  for (int t = 0; t < motion.frames(); ++t) {
    FrameState& frame = frames[t];
    Rates(dynamics->model(), motion, t, &qvel, &qacc);
    dynamics->SetPose(motion.qpos[t]);
    frame.lowest = dynamics->LowestPoints();
    frame.centre = dynamics->CentreOfMass();
    for (size_t i = 0; i < points.size(); ++i) {
      const auto jacobian =
          dynamics->PointJacobian(points[i].body, frame.lowest[i]);
      frame.speed.push_back((jacobian * qvel).norm());
      if (frame.lowest[i].z() < frame.low()) {
        frame.lowest_point = static_cast<int>(i);
      }
    }
  }
  return frames;
}

int Wrapped(int t, int frames, bool loops) {
  return loops ? (t + frames) % frames : std::clamp(t, 0, frames - 1);
}

// (a_z + g) / g of the centre of mass over three frames.
double Support(const std::vector<FrameState>& frames,
               const ModelMotion& motion, double gravity, int t) {
  const int n = motion.frames();
  const int middle = motion.loops ? t : std::clamp(t, 1, std::max(1, n - 2));
  const auto height = [&](int frame) {
    return frames[Wrapped(frame, n, motion.loops)].centre.z();
  };
  const double rate = motion.rate;
  const double acceleration =
      (height(middle - 1) - 2 * height(middle) + height(middle + 1)) * rate *
      rate;
  return acceleration / gravity + 1;
}

void FlipSingles(bool loops, std::vector<bool>* flags) {
  const std::vector<bool> before = *flags;
  const int n = static_cast<int>(before.size());
  for (int t = 0; t < n; ++t) {
    const bool left = before[Wrapped(t - 1, n, loops)];
    const bool right = before[Wrapped(t + 1, n, loops)];
    const bool inside = loops || (t > 0 && t + 1 < n);
    if (inside && left == right && left != before[t]) (*flags)[t] = left;
  }
}

// c minimising sum over supported of (c + low)^2 + stiffness * sum (c'')^2.
VectorXd HeightCorrection(const VectorXd& low,
                          const std::vector<bool>& supported, bool loops) {
  const int n = static_cast<int>(low.size());
  std::vector<Eigen::Triplet<double>> entries;
  VectorXd right = VectorXd::Zero(n);
  for (int t = 0; t < n; ++t) {
    // Nothing else holds a motion with fewer than two supported frames.
    entries.emplace_back(t, t, supported[t] ? 1 : 1e-9);
    if (supported[t]) right[t] = -low[t];
    if (!loops && (t == 0 || t + 1 == n)) continue;
    const int index[3] = {Wrapped(t - 1, n, loops), t,
                          Wrapped(t + 1, n, loops)};
    const double coefficient[3] = {1, -2, 1};
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b) {
        entries.emplace_back(
            index[a], index[b],
            kGroundStiffness * coefficient[a] * coefficient[b]);
      }
    }
  }
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(matrix).solve(
      right);
}

// Moves frames begin+1 .. end-1 (continued over the loop) onto the parabola
// between the centres of mass of begin and end.
void MakeBallistic(Dynamics* dynamics, int begin, int end,
                   ModelMotion* motion) {
  const auto centre = [&](int t) {
    dynamics->SetPose(FrameAt(*motion, t));
    return dynamics->CentreOfMass();
  };
  const double duration = (end - begin) * motion->dt();
  const Vector3d from = centre(begin);
  const Vector3d gravity(0, 0, dynamics->model().opt.gravity[2]);
  const Vector3d velocity =
      (centre(end) - from) / duration - gravity * duration / 2;
  for (int t = begin + 1; t < end; ++t) {
    const double time = (t - begin) * motion->dt();
    const Vector3d wanted =
        from + velocity * time + gravity * time * time / 2;
    // In a frame after the seam the shift would have to turn back with the
    // cycle; a vertical one need not.
    const Vector3d shift = wanted - centre(t);
    VectorXd& qpos = motion->qpos[t % motion->frames()];
    if (t < motion->frames() || motion->cycle.yaw == 0) {
      qpos.head<3>() += shift;
    } else {
      qpos[2] += shift.z();
    }
  }
}

}  // namespace

std::vector<bool> FindSupport(Dynamics* dynamics, const ModelMotion& motion) {
  const std::vector<FrameState> frames = MeasureFrames(dynamics, motion);
  const double gravity = -dynamics->model().opt.gravity[2];
  std::vector<bool> supported;
  std::vector<double> heights;
  int lowest = 0;
  for (int t = 0; t < motion.frames(); ++t) {
    const FrameState& frame = frames[t];
    supported.push_back(
        frame.speed[frame.lowest_point] < kContactSpeed &&
        Support(frames, motion, gravity, t) > kLeastSupport);
    if (supported.back()) heights.push_back(frame.low());
    if (frame.low() < frames[lowest].low()) lowest = t;
  }
  if (heights.empty()) {
    supported[lowest] = true;
    return supported;
  }
  std::nth_element(heights.begin(), heights.begin() + heights.size() / 2,
                   heights.end());
  const double limit = heights[heights.size() / 2] + kGroundBand;
  for (int t = 0; t < motion.frames(); ++t) {
    if (frames[t].low() > limit) supported[t] = false;
  }
  FlipSingles(motion.loops, &supported);
  return supported;
}

void CalibrateGround(Dynamics* dynamics, const std::vector<bool>& supported,
                     ModelMotion* motion) {
  VectorXd low(motion->frames());
  for (int t = 0; t < motion->frames(); ++t) {
    dynamics->SetPose(motion->qpos[t]);
    low[t] = INFINITY;
    for (const Vector3d& point : dynamics->LowestPoints()) {
      low[t] = std::min(low[t], point.z());
    }
  }
  const VectorXd correction = HeightCorrection(low, supported, motion->loops);
  for (int t = 0; t < motion->frames(); ++t) {
    motion->qpos[t][2] += correction[t];
  }
}

void MakeFlightsBallistic(Dynamics* dynamics,
                          const std::vector<bool>& supported,
                          ModelMotion* motion) {
  const int n = motion->frames();
  for (int begin = 0; begin < n; ++begin) {
    int end = begin + 1;
    const int limit = motion->loops ? begin + n : n - 1;
    while (end <= limit && !supported[end % n]) ++end;
    if (!supported[begin] || end > limit || end - begin < 3) continue;
    MakeBallistic(dynamics, begin, end, motion);
  }
}

std::vector<std::vector<bool>> FindBearingPoints(
    Dynamics* dynamics, const std::vector<bool>& supported,
    const ModelMotion& motion) {
  const std::vector<FrameState> frames = MeasureFrames(dynamics, motion);
  std::vector<std::vector<bool>> bearing;
  for (int t = 0; t < motion.frames(); ++t) {
    std::vector<bool> points;
    for (size_t i = 0; i < frames[t].lowest.size(); ++i) {
      points.push_back(supported[t] &&
                       frames[t].lowest[i].z() < kContactMargin &&
                       frames[t].speed[i] < kContactSpeed);
    }
    bearing.push_back(points);
  }
  return bearing;
}

}  // namespace sinew::import
