#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/status_macros.h"
#include "sim/import/edit.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

// A lift is a bump over the whole gap; what it must reach near the ends, where
// it is lower than this, is left to the floor calibration.
constexpr double kLeastLift = 0.2;
constexpr int kRootPosition = 7;
constexpr int kRootVelocity = 6;

absl::Status CheckBlend(const ModelMotion& first, const ModelMotion& second,
                        double gap_s) {
  if (first.rate != second.rate) {
    return absl::InvalidArgumentError(
        absl::StrCat("blend: expected equal rates, found ", first.rate, " and ",
                     second.rate, " frames per second"));
  }
  if (first.qpos[0].size() != second.qpos[0].size()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "blend: expected motions of one model, found ", first.qpos[0].size(),
        " and ", second.qpos[0].size(), " coordinates"));
  }
  return CheckBlendGap(gap_s);
}

// One side of the gap; velocities as in qvel: linear in the world, angular in
// the root's frame.
struct Side {
  VectorXd qpos, qvel;

  Quaterniond rotation() const { return motion::FromWxyz(qpos.data() + 3); }
  Vector3d linear() const { return qvel.head<3>(); }
  Vector3d angular() const { return qvel.segment<3>(3); }
  double yaw_rate() const { return (rotation() * angular()).z(); }
};

Side LookAt(const mjModel& model, const ModelMotion& motion, int t) {
  Side side{.qpos = motion.qpos[t], .qvel = {}};
  ModelMotion once = motion;  // looping motions count as their frames
  once.loops = false;
  VectorXd qacc;
  Rates(model, once, t, &side.qvel, &qacc);
  return side;
}

// `motion` turned about the root of its first frame, which goes to x, y.
ModelMotion Place(const ModelMotion& motion, double yaw, double x, double y) {
  ModelMotion placed = motion;
  const Quaterniond turn = motion::YawRotation(yaw);
  const Vector3d from(motion.qpos[0].x(), motion.qpos[0].y(), 0);
  for (VectorXd& qpos : placed.qpos) {
    const Vector3d place = qpos.head<3>();
    qpos.head<3>() = turn * (place - from) + Vector3d(x, y, 0);
    motion::ToWxyz(turn * motion::FromWxyz(qpos.data() + 3), qpos.data() + 3);
  }
  return placed;
}

// `second` where the mean of both velocities leads to in `seconds`.
ModelMotion Continue(const Side& end, const Side& begin,
                     const ModelMotion& second, double seconds) {
  const double yaw = motion::Yaw(end.rotation()) +
                     seconds * (end.yaw_rate() + begin.yaw_rate()) / 2 -
                     motion::Yaw(begin.rotation());
  const Vector3d velocity =
      (end.linear() + motion::YawRotation(yaw) * begin.linear()) / 2;
  return Place(second, yaw, end.qpos[0] + seconds * velocity.x(),
               end.qpos[1] + seconds * velocity.y());
}

// Cubic Hermite from a to b with end tangents da and db, share in [0, 1].
template <typename Vector>
Vector Cubic(const Vector& a, const Vector& da, const Vector& b,
             const Vector& db, double share) {
  const double s = share;
  const double rest = 1 - s;
  return rest * rest * (1 + 2 * s) * a + s * rest * rest * da +
         s * s * (3 - 2 * s) * b - s * s * rest * db;
}

VectorXd Between(const Side& a, const Side& b, double seconds, double share) {
  VectorXd qpos = a.qpos;
  const auto joints = a.qpos.size() - kRootPosition;
  qpos.head<3>() =
      Cubic<Vector3d>(a.qpos.head<3>(), seconds * a.linear(), b.qpos.head<3>(),
                      seconds * b.linear(), share);
  const Vector3d turn = motion::Log(a.rotation().conjugate() * b.rotation());
  const Vector3d turned = Cubic<Vector3d>(
      Vector3d::Zero(), seconds * a.angular(), turn,
      motion::InverseRightJacobian(turn) * (seconds * b.angular()), share);
  motion::ToWxyz((a.rotation() * motion::Exp(turned)).normalized(),
                 qpos.data() + 3);
  qpos.tail(joints) = Cubic<VectorXd>(
      a.qpos.tail(joints), seconds * a.qvel.tail(a.qvel.size() - kRootVelocity),
      b.qpos.tail(joints), seconds * b.qvel.tail(b.qvel.size() - kRootVelocity),
      share);
  return qpos;
}

// Lifts the frames of the gap by a bump with flat ends, high enough that
// nothing is below the floor.
void Lift(Dynamics* dynamics, std::vector<VectorXd>* frames) {
  const auto count = static_cast<double>(frames->size() + 1);
  const auto bump = [&](size_t i) {
    const double s = static_cast<double>(i + 1) / count;
    return 16 * s * s * (1 - s) * (1 - s);
  };
  double lift = 0;
  for (size_t i = 0; i < frames->size(); ++i) {
    dynamics->SetPose((*frames)[i]);
    const double depth = -dynamics->LowestHeight();
    lift = std::max(lift, depth / std::max(bump(i), kLeastLift));
  }
  for (size_t i = 0; i < frames->size(); ++i) {
    (*frames)[i][2] += lift * bump(i);
  }
}

}  // namespace

absl::Status CheckBlendGap(double gap_s) {
  if (gap_s > 0 && gap_s <= kMostBlendGap) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("blend: expected a gap of more than 0 and at most ",
                   kMostBlendGap, " s, found ", gap_s));
}

int BlendSteps(double gap_s, double rate) {
  return std::max(1, static_cast<int>(std::lround(gap_s * rate)));
}

absl::StatusOr<ModelMotion> Blend(Dynamics* dynamics, const ModelMotion& first,
                                  const ModelMotion& second, double gap_s) {
  SINEW_RETURN_IF_ERROR(CheckBlend(first, second, gap_s));
  const mjModel& model = dynamics->model();
  const int steps = BlendSteps(gap_s, first.rate);
  const double seconds = steps / first.rate;
  const Side end = LookAt(model, first, first.frames() - 1);
  const ModelMotion placed =
      Continue(end, LookAt(model, second, 0), second, seconds);
  const Side begin = LookAt(model, placed, 0);
  std::vector<VectorXd> gap;
  for (int i = 1; i < steps; ++i) {
    gap.push_back(Between(end, begin, seconds, static_cast<double>(i) / steps));
  }
  Lift(dynamics, &gap);
  ModelMotion blended;
  blended.rate = first.rate;
  for (const std::vector<VectorXd>* part :
       {&first.qpos, &std::as_const(gap), &placed.qpos}) {
    blended.qpos.insert(blended.qpos.end(), part->begin(), part->end());
  }
  return blended;
}

}  // namespace sinew::import
