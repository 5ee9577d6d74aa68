#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "sim/import/edit.h"
#include "sim/import/retarget/ground.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Costs within this are equal.
constexpr double kEqualCost = 1e-9;
// Coordinates of the free joint.
constexpr int kRootPosition = 7;
constexpr int kRootVelocity = 6;

// A frame as FindLoop compares it.
struct Sight {
  VectorXd vector;   // what differs by its Euclidean distance
  Quaterniond tilt;  // the root's rotation less its heading
  std::vector<bool> contact;
};

Sight Look(const mjModel& model, const ModelMotion& motion, int t) {
  VectorXd qvel, qacc;
  Rates(model, motion, t, &qvel, &qacc);
  const VectorXd& qpos = motion.qpos[t];
  const Quaterniond rotation = motion::FromWxyz(qpos.data() + 3);
  const Quaterniond to_heading = motion::YawRotation(-motion::Yaw(rotation));
  const int joints = model.nq - kRootPosition;
  const double share = 1 / std::sqrt(std::max(joints, 1));
  Sight sight;
  sight.tilt = to_heading * rotation;
  sight.vector.resize(2 * joints + 4);
  sight.vector << share * qpos.tail(joints),
      share * kLoopTime * qvel.tail(model.nv - kRootVelocity),
      kLoopPerMetre * qpos[2],
      kLoopPerMetre * kLoopTime * (to_heading * qvel.head<3>());
  return sight;
}

double SquaredCost(const Sight& a, const Sight& b) {
  double cost = (a.vector - b.vector).squaredNorm();
  const double tilt = motion::AngleBetween(a.tilt, b.tilt);
  cost += tilt * tilt;
  for (size_t f = 0; f < a.contact.size(); ++f) {
    if (a.contact[f] != b.contact[f]) cost += kLoopContact * kLoopContact;
  }
  return cost;
}

}  // namespace

std::vector<std::vector<bool>> FootContacts(Dynamics* dynamics,
                                            const ModelMotion& motion) {
  const ImportModel& model = dynamics->import_model();
  const std::vector<bool> supported =
      FindSupport(dynamics, motion, /*ground=*/0);
  const std::vector<std::vector<bool>> bearing =
      FindBearingPoints(dynamics, supported, motion);
  std::vector<std::vector<bool>> contacts(
      motion.frames(), std::vector<bool>(model.feet.size(), false));
  for (int t = 0; t < motion.frames(); ++t) {
    for (int p = 0; p < static_cast<int>(model.points.size()); ++p) {
      const int foot = model.FootOf(p);
      if (foot >= 0 && bearing[t][p]) contacts[t][foot] = true;
    }
  }
  return contacts;
}

absl::StatusOr<Loop> FindLoop(Dynamics* dynamics, const ModelMotion& motion,
                              const LoopOptions& options) {
  if (!(options.least_s > 0 && options.most_s >= options.least_s)) {
    return absl::InvalidArgumentError(
        absl::StrCat("loop: expected periods with 0 < least <= most, found ",
                     options.least_s, " s to ", options.most_s, " s"));
  }
  const auto contacts = FootContacts(dynamics, motion);
  std::vector<Sight> sights;
  for (int t = 0; t < motion.frames(); ++t) {
    sights.push_back(Look(dynamics->model(), motion, t));
    sights.back().contact = contacts[t];
  }
  const int least = std::max(
      2, static_cast<int>(std::ceil(options.least_s * motion.rate - 1e-6)));
  const double most = options.most_s * motion.rate + 1e-6;
  Loop best{.cost = INFINITY};
  for (int first = 0; first + least < motion.frames(); ++first) {
    for (int last = first + least;
         last < motion.frames() && last - first <= most; ++last) {
      const double cost = std::sqrt(SquaredCost(sights[first], sights[last]));
      const bool longer = last - first > best.last - best.first;
      if (cost < best.cost - kEqualCost ||
          (longer && cost < best.cost + kEqualCost)) {
        best = {.first = first, .last = last, .cost = cost};
      }
    }
  }
  if (best.cost <= kLoopMostCost) return best;
  return absl::NotFoundError(absl::StrCat(
      "loop: expected a pair of frames that differ by at most ", kLoopMostCost,
      ", found ",
      std::isinf(best.cost)
          ? absl::StrCat("a motion shorter than ", options.least_s, " s")
          : absl::StrCat("none nearer than ", best.cost, " (frames ",
                         best.first, " and ", best.last, ")")));
}

ModelMotion CloseLoop(const ModelMotion& motion, const Loop& loop) {
  const VectorXd& begin = motion.qpos[loop.first];
  const VectorXd& end = motion.qpos[loop.last];
  const Quaterniond begin_rotation = motion::FromWxyz(begin.data() + 3);
  const Quaterniond end_rotation = motion::FromWxyz(end.data() + 3);
  double yaw = motion::Unwrap(
      motion::Yaw(end_rotation) - motion::Yaw(begin_rotation), 0);
  if (std::abs(yaw) < kLeastCycleYaw) yaw = 0;

  // What frame `last`, moved back, lacks to frame `first`.
  const VectorXd joints = (begin - end).tail(begin.size() - kRootPosition);
  const double height = begin[2] - end[2];
  const Vector3d turn = motion::Log(
      (motion::YawRotation(-yaw) * end_rotation).conjugate() * begin_rotation);

  ModelMotion closed;
  closed.rate = motion.rate;
  closed.loops = true;
  closed.cycle = {.x = end[0] - begin[0], .y = end[1] - begin[1], .yaw = yaw};
  const int frames = loop.last - loop.first;
  for (int i = 0; i < frames; ++i) {
    const double share = static_cast<double>(i) / frames - 0.5;
    VectorXd qpos = motion.qpos[loop.first + i];
    qpos.tail(joints.size()) += share * joints;
    qpos[2] += share * height;
    motion::ToWxyz(
        (motion::FromWxyz(qpos.data() + 3) * motion::Exp(share * turn))
            .normalized(),
        qpos.data() + 3);
    closed.qpos.push_back(std::move(qpos));
  }
  return closed;
}

}  // namespace sinew::import
