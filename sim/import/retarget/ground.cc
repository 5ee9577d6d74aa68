#include "sim/import/retarget/ground.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "sim/import/retarget/contact_fit.h"

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

// (a_z + g) / g of the centre of mass in the frames, smoothed by (1, 2, 1).
std::vector<double> Support(const std::vector<FrameState>& frames,
                            const ModelMotion& motion, double gravity) {
  const int n = motion.frames();
  const double rate = motion.rate;
  std::vector<double> raw;
  for (int t = 0; t < n; ++t) {
    const int middle = motion.loops ? t : std::clamp(t, 1, std::max(1, n - 2));
    const auto height = [&](int frame) {
      return frames[Wrapped(frame, n, motion.loops)].centre.z();
    };
    const double change =
        height(middle - 1) - 2 * height(middle) + height(middle + 1);
    raw.push_back(change * rate * rate / gravity + 1);
  }
  std::vector<double> smooth;
  for (int t = 0; t < n; ++t) {
    smooth.push_back(raw[Wrapped(t - 1, n, motion.loops)] / 4 + raw[t] / 2 +
                     raw[Wrapped(t + 1, n, motion.loops)] / 4);
  }
  return smooth;
}

// Share of the way from `carried` to `flying`, mapped to [-1, 1].
double Vote(double value, double carried, double flying) {
  return std::clamp(2 * (value - carried) / (flying - carried) - 1, -1.0, 1.0);
}

// Signs of the cheapest series under evidence e: a flying frame costs -e, a
// change kFlightChange. For a loop both first states are tried.
std::vector<bool> MostLikelyFlight(const std::vector<double>& evidence,
                                   bool loops) {
  const int n = static_cast<int>(evidence.size());
  double best_cost = INFINITY;
  std::vector<bool> best;
  for (const int first : {0, 1}) {
    std::vector<std::array<int, 2>> before(n);
    std::array<double, 2> cost = {INFINITY, INFINITY};
    cost[first] = first == 1 ? -evidence[0] : 0;
    for (int t = 1; t < n; ++t) {
      std::array<double, 2> next;
      for (const int to : {0, 1}) {
        const double change = cost[1 - to] + kFlightChange;
        before[t][to] = change < cost[to] ? 1 - to : to;
        next[to] = std::min(cost[to], change) + (to == 1 ? -evidence[t] : 0);
      }
      cost = next;
    }
    if (loops) cost[1 - first] += kFlightChange;
    int state = cost[1] < cost[0] ? 1 : 0;
    if (cost[state] >= best_cost) continue;
    best_cost = cost[state];
    best.assign(n, false);
    for (int t = n - 1; t >= 0; --t) {
      best[t] = state == 1;
      if (t > 0) state = before[t][state];
    }
  }
  return best;
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
    const Vector3d wanted = from + velocity * time + gravity * time * time / 2;
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

double Percentile(std::vector<double> values, double share) {
  const auto index =
      static_cast<int64_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + index, values.end());
  return values[index];
}

std::vector<bool> FindSupport(Dynamics* dynamics, const ModelMotion& motion,
                              std::optional<double> ground) {
  const std::vector<FrameState> frames = MeasureFrames(dynamics, motion);
  const std::vector<double> support =
      Support(frames, motion, -dynamics->model().opt.gravity[2]);
  std::vector<double> heights;
  for (const FrameState& frame : frames) heights.push_back(frame.low());
  const double floor = ground.value_or(Percentile(heights, 0.3));
  std::vector<double> evidence;
  for (size_t t = 0; t < frames.size(); ++t) {
    const double speed = frames[t].speed[frames[t].lowest_point];
    evidence.push_back(2 * Vote(heights[t] - floor, 0, kFlightHeight) +
                       Vote(speed, 0, kFlightSpeed) + Vote(support[t], 1, 0) -
                       kFlightBias);
  }
  std::vector<bool> supported = MostLikelyFlight(evidence, motion.loops);
  supported.flip();
  const auto lowest = std::min_element(heights.begin(), heights.end());
  supported[lowest - heights.begin()] = true;
  return supported;
}

void CalibrateGround(Dynamics* dynamics, const std::vector<bool>& supported,
                     ModelMotion* motion) {
  VectorXd low(motion->frames());
  for (int t = 0; t < motion->frames(); ++t) {
    dynamics->SetPose(motion->qpos[t]);
    low[t] = dynamics->LowestHeight();
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

std::vector<bool> PlaceOnFloor(Dynamics* dynamics, ModelMotion* motion) {
  std::vector<bool> supported = FindSupport(dynamics, *motion);
  CalibrateGround(dynamics, supported, motion);
  supported = FindSupport(dynamics, *motion, /*ground=*/0);
  CalibrateGround(dynamics, supported, motion);
  MakeFlightsBallistic(dynamics, supported, motion);
  return supported;
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
