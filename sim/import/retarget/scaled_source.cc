#include "sim/import/retarget/scaled_source.h"

#include <algorithm>

#include "absl/strings/match.h"

namespace sinew::import {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

bool EndsALimb(const std::string& role) {
  return absl::EndsWith(role, "_wrist") || absl::EndsWith(role, "_ankle") ||
         role == "head";
}

// How one role is placed.
struct Placing {
  int point = -1;     // index into BodyMap::points, -1: none
  int limb = -1;      // role above in the limb; -1: as the model's
  double length = 0;  // of the limb, m
  int foot = -1;      // index into BodyMap::bodies of a toe's foot; -1: no toe
  Vector3d from_ankle = Vector3d::Zero();  // in the foot's frame, m
};

// A toe that does not turn by itself lies where its foot's rotation has it.
void PlaceToe(const BodyMap& map, int role, Placing* placing) {
  if (placing->point < 0) return;
  const RolePoint& toe = map.points[placing->point];
  const MappedBody& foot = map.bodies[toe.mapped];
  const int ankle = map.FindPoint(foot.role);
  if (foot.role == role || ankle < 0) return;
  placing->foot = toe.mapped;
  placing->from_ankle = toe.position - map.points[ankle].position;
}

std::vector<Placing> Placings(const RoleTrack& track, const BodyMap& map,
                              const ModelMotion& motion, Dynamics* dynamics) {
  dynamics->SetPose(motion.qpos[0]);
  std::vector<Placing> placings;
  for (size_t role = 0; role < track.roles.size(); ++role) {
    Placing placing;
    placing.point = map.FindPoint(static_cast<int>(role));
    const std::string above = LimbParent(track.roles[role]);
    const int above_point = map.FindPoint(track.Find(above));
    if (placing.point >= 0 && above_point >= 0) {
      placing.limb = track.Find(above);
      placing.length = (PointPlace(map, map.points[placing.point], *dynamics) -
                        PointPlace(map, map.points[above_point], *dynamics))
                           .norm();
    }
    if (absl::EndsWith(track.roles[role], "_toe")) {
      PlaceToe(map, static_cast<int>(role), &placing);
    }
    placings.push_back(placing);
  }
  return placings;
}

}  // namespace

Vector3d PointPlace(const BodyMap& map, const RolePoint& point,
                    const Dynamics& dynamics) {
  const int body = map.bodies[point.mapped].body;
  const mjData& data = dynamics.data();
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> frame(
      data.xmat + 9 * body);
  return Eigen::Map<const Vector3d>(data.xpos + 3 * body) +
         frame * point.position;
}

ScaledSource ScaleSource(const RoleTrack& track, const BodyMap& map,
                         const ModelMotion& motion, Dynamics* dynamics) {
  const std::vector<Placing> placings = Placings(track, map, motion, dynamics);
  const int left = track.Find("left_hip"), right = track.Find("right_hip");
  const RolePoint& left_hip = map.points[map.FindPoint(left)];
  const RolePoint& right_hip = map.points[map.FindPoint(right)];
  ScaledSource scaled;
  for (int t = 0; t < motion.frames(); ++t) {
    dynamics->SetPose(motion.qpos[t]);
    std::vector<Vector3d>& places = scaled.emplace_back();
    const std::vector<Vector3d>& source = track.position[t];
    const Vector3d hips = (PointPlace(map, left_hip, *dynamics) +
                           PointPlace(map, right_hip, *dynamics)) /
                          2;
    for (size_t role = 0; role < placings.size(); ++role) {
      const Placing& placing = placings[role];
      const int above = placing.limb >= 0 ? placing.limb : track.parent[role];
      if (placing.limb >= 0) {
        places.push_back(places[above] +
                         placing.length *
                             (source[role] - source[above]).normalized());
        if (absl::EndsWith(track.roles[role], "_wrist")) {
          const Vector3d from_hips =
              hips +
              map.scale * (source[role] - (source[left] + source[right]) / 2);
          places.back() += kHandShare * (from_hips - places.back());
        }
      } else if (placing.foot >= 0) {
        const MappedBody& foot = map.bodies[placing.foot];
        places.push_back(places[foot.role] + track.rotation[t][foot.role] *
                                                 foot.alignment *
                                                 placing.from_ankle);
      } else if (placing.point >= 0) {
        places.push_back(PointPlace(map, map.points[placing.point], *dynamics));
      } else {
        places.push_back(places[above] +
                         map.scale * (source[role] - source[above]));
      }
    }
  }
  return scaled;
}

void MeasureRetargetError(const RoleTrack& track, const BodyMap& map,
                          const ScaledSource& wanted, const ModelMotion& motion,
                          Dynamics* dynamics, v1::ClipQuality* quality) {
  std::vector<double> sum(map.points.size(), 0), most(map.points.size(), 0);
  for (int t = 0; t < motion.frames(); ++t) {
    dynamics->SetPose(motion.qpos[t]);
    for (size_t i = 0; i < map.points.size(); ++i) {
      const double distance = (PointPlace(map, map.points[i], *dynamics) -
                               wanted[t][map.points[i].role])
                                  .norm();
      sum[i] += distance;
      most[i] = std::max(most[i], distance);
    }
  }
  double ends = 0;
  int count = 0;
  for (size_t i = 0; i < map.points.size(); ++i) {
    const std::string& role = track.roles[map.points[i].role];
    const double mean = sum[i] / motion.frames();
    v1::RetargetError* error = quality->add_retarget_errors();
    error->set_joint(role);
    error->set_mean_m(mean);
    error->set_max_m(most[i]);
    if (!EndsALimb(role)) continue;
    ends += mean;
    ++count;
  }
  quality->set_retarget_error_m(count == 0 ? 0 : ends / count);
}

}  // namespace sinew::import
