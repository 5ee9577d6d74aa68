#include "sim/import/retarget/foot_lock.h"

#include <algorithm>
#include <cmath>

#include "sim/import/retarget/zero_pose.h"

namespace sinew::import {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Points of a foot this much above its lowest one are no sole, m.
constexpr double kSoleDepth = 0.015;
// Weight of a frame in the mean place: 1 / (this + speed), m/s.
constexpr double kSlow = 0.05;

// The corners of all soles, indices into ImportModel::points.
std::vector<int> SolePoints(const ImportModel& model) {
  const ZeroPose zero(*model.model, model.model->jnt_bodyid[0]);
  std::vector<int> corners;
  for (const int foot : model.feet) {
    std::vector<std::pair<int, Vector3d>> points;
    double lowest = INFINITY;
    for (size_t i = 0; i < model.points.size(); ++i) {
      const GroundPoint& point = model.points[i];
      if (point.body != foot) continue;
      Vector3d place = zero.rotation[foot] * point.position;
      place.z() -= point.radius;
      lowest = std::min(lowest, place.z());
      points.emplace_back(static_cast<int>(i), place);
    }
    std::erase_if(points, [lowest](const auto& point) {
      return point.second.z() > lowest + kSoleDepth;
    });
    for (const double x : {1.0, -1.0}) {
      for (const double y : {1.0, -1.0}) {
        const auto corner = std::max_element(
            points.begin(), points.end(), [x, y](const auto& a, const auto& b) {
              return x * a.second.x() + y * a.second.y() <
                     x * b.second.x() + y * b.second.y();
            });
        if (corner == points.end()) continue;
        if (std::find(corners.begin(), corners.end(), corner->first) ==
            corners.end()) {
          corners.push_back(corner->first);
        }
      }
    }
  }
  return corners;
}

// Finds the stands of one point.
class Stands {
 public:
  Stands(const ModelMotion& motion, std::vector<Vector3d> places)
      : motion_(motion), places_(std::move(places)) {}

  // Calls add(frame, place, slides) for every frame of every stand.
  template <typename Add>
  void Visit(const std::vector<bool>& supported, const Add& add) const {
    const int n = frames();
    std::vector<bool> stands(n);
    for (int t = 0; t < n; ++t) {
      stands[t] =
          supported[t] && places_[t].z() < kLockHeight && Speed(t) < kLockSpeed;
    }
    FillGaps(&stands);
    const auto pause = std::find(stands.begin(), stands.end(), false);
    const bool around = motion_.loops && pause != stands.end();
    const int first = around ? static_cast<int>(pause - stands.begin()) : 0;
    for (int begin = first; begin < first + n;) {
      int end = begin;
      while (end < first + n && (around || end < n) && stands[end % n]) ++end;
      if (end - begin >= kLeastStand) VisitStand(begin, end, add);
      begin = end + 1;
    }
  }

 private:
  int frames() const { return motion_.frames(); }

  // The point in a frame of the motion continued over the loop.
  Vector3d At(int t) const {
    const int n = frames();
    if (!motion_.loops) return places_[std::clamp(t, 0, n - 1)];
    if (t < 0) return Cycled(places_[t + n], /*forward=*/false);
    if (t >= n) return Cycled(places_[t - n], /*forward=*/true);
    return places_[t];
  }

  Vector3d Cycled(const Vector3d& place, bool forward) const {
    return motion_.cycle.Move(place, motion_.qpos[0].head<3>(), forward);
  }

  double Speed(int t) const {
    return (At(t + 1) - At(t - 1)).norm() * motion_.rate / 2;
  }

  void FillGaps(std::vector<bool>* stands) const {
    const int n = frames();
    int last = -1;
    for (int t = 0; t < n; ++t) {
      if (!(*stands)[t]) continue;
      if (last >= 0 && t - last - 1 <= kLargestGap) {
        std::fill(stands->begin() + last, stands->begin() + t, true);
      }
      last = t;
    }
  }

  template <typename Add>
  void VisitStand(int begin, int end, const Add& add) const {
    Vector3d mean = Vector3d::Zero();
    double sum = 0;
    for (int t = begin; t < end; ++t) {
      const double weight = 1 / (kSlow + Speed(t % frames()));
      mean += weight * At(t);
      sum += weight;
    }
    mean /= sum;
    double reach = 0;
    for (int t = begin; t < end; ++t) {
      reach = std::max(reach, (At(t) - mean).head<2>().norm());
    }
    for (int t = begin; t < end; ++t) {
      const Vector3d place =
          t < frames() ? mean : Cycled(mean, /*forward=*/false);
      add(t % frames(), Vector2d(place.head<2>()), reach > kLeastSlide);
    }
  }

  const ModelMotion& motion_;
  const std::vector<Vector3d> places_;  // [frames]
};

}  // namespace

std::vector<std::vector<Lock>> FindLocks(const std::vector<bool>& supported,
                                         const ModelMotion& motion,
                                         Dynamics* dynamics) {
  const ImportModel& model = dynamics->import_model();
  const std::vector<int> soles = SolePoints(model);
  std::vector<std::vector<Vector3d>> places(soles.size());
  for (int t = 0; t < motion.frames(); ++t) {
    dynamics->SetPose(motion.qpos[t]);
    for (size_t i = 0; i < soles.size(); ++i) {
      places[i].push_back(dynamics->LowestPoint(soles[i]));
    }
  }
  std::vector<std::vector<Lock>> locks(motion.frames());
  for (size_t i = 0; i < soles.size(); ++i) {
    Stands(motion, std::move(places[i]))
        .Visit(supported, [&](int t, const Vector2d& place, bool slides) {
          locks[t].push_back({soles[i], place, slides});
        });
  }
  return locks;
}

}  // namespace sinew::import
