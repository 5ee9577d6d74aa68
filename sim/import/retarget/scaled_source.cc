#include "sim/import/retarget/scaled_source.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/match.h"

namespace sinew::import {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Matrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

// How far an elbow is off the line from shoulder to hand, m: in an arm that is
// straight; at least, in one that is surely bent; what is nearer is on it.
constexpr double kStraight = 0.01;
constexpr double kBent = 0.03;
constexpr double kNowhere = 1e-6;

Eigen::Map<const Matrix> Frame(int body, const Dynamics& dynamics) {
  return Eigen::Map<const Matrix>(dynamics.data().xmat + 9 * body);
}

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
  // Of a hand: where its elbow goes when the arm bends, in the frame of the
  // upper arm at index `upper` of BodyMap::bodies; -1: not known.
  int upper = -1;
  Vector3d bend = Vector3d::Zero();  // unit
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

// The part of `vector` that is square to `axis`.
Vector3d Across(const Vector3d& vector, const Vector3d& axis) {
  const Vector3d along = axis.normalized();
  return vector - along * along.dot(vector);
}

// How the arm that ends at `hand` bends: as the model's does with the elbow in
// the middle of its range.
void PlaceElbow(const RoleTrack& track, const BodyMap& map,
                const VectorXd& qpos, const RolePoint& hand, Dynamics* dynamics,
                Placing* placing) {
  const int elbow = map.FindPoint(placing->limb);
  const int shoulder = map.FindPoint(
      track.Find(LimbParent(track.roles[static_cast<size_t>(placing->limb)])));
  if (elbow < 0 || shoulder < 0) return;
  const MappedBody& forearm = map.bodies[map.points[elbow].mapped];
  if (forearm.role != placing->limb || forearm.chain.size() == 0) return;
  const double middle =
      (forearm.chain.lower.front() + forearm.chain.upper.front()) / 2;
  if (!std::isfinite(middle)) return;
  const mjModel& model = dynamics->model();
  const int address = model.jnt_qposadr[forearm.chain.joints.front()];
  VectorXd bent = qpos;
  bent[address] = model.qpos0[address] + middle;
  dynamics->SetPose(bent);
  const Vector3d origin = PointPlace(map, map.points[shoulder], *dynamics);
  const Vector3d out =
      Across(PointPlace(map, map.points[elbow], *dynamics) - origin,
             PointPlace(map, hand, *dynamics) - origin);
  if (out.norm() < kStraight) return;
  placing->upper = forearm.parent;
  placing->bend =
      Frame(map.bodies[forearm.parent].body, *dynamics).transpose() *
      out.normalized();
}

std::vector<Placing> Placings(const RoleTrack& track, const BodyMap& map,
                              const ModelMotion& motion, Dynamics* dynamics) {
  std::vector<Placing> placings;
  for (size_t role = 0; role < track.roles.size(); ++role) {
    dynamics->SetPose(motion.qpos[0]);
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
    if (placing.limb >= 0 && absl::EndsWith(track.roles[role], "_wrist")) {
      PlaceElbow(track, map, motion.qpos[0], map.points[placing.point],
                 dynamics, &placing);
    }
    placings.push_back(placing);
  }
  return placings;
}

// Bends a limb of bones of `upper` and `lower` metres so that its end is at
// `place`, or as near to it as they reach, with the middle joint on the side
// where `out` points.
void BendLimb(const Vector3d& origin, double upper, double lower,
              const Vector3d& place, const Vector3d& out, Vector3d* middle,
              Vector3d* end) {
  const Vector3d along = (place - origin).normalized();
  const double reach = std::clamp((place - origin).norm(),
                                  std::abs(upper - lower), upper + lower);
  const double share =
      (upper * upper - lower * lower + reach * reach) / (2 * reach);
  const double off = std::sqrt(std::max(0.0, upper * upper - share * share));
  *middle = origin + share * along + off * out.normalized();
  *end = origin + reach * along;
}

// Draws the hand at `role` to `place`, and its elbow as near to where the
// source's limb has it as the bones allow.
void PlaceHand(const std::vector<Placing>& placings, const BodyMap& map,
               size_t role, const Vector3d& place, const Dynamics& dynamics,
               std::vector<Vector3d>* places) {
  const Placing& placing = placings[role];
  const int shoulder = placings[placing.limb].limb;
  if (shoulder < 0) return;
  const Vector3d& origin = (*places)[shoulder];
  Vector3d& elbow = (*places)[placing.limb];
  const Vector3d axis = place - origin;
  if (axis.norm() < kNowhere) return;
  // How far the source's own arm is from straight.
  const double off = Across(elbow - origin, (*places)[role] - origin).norm();
  Vector3d out = Across(elbow - origin, axis);
  if (placing.upper >= 0) {
    const Vector3d bend = Across(
        Frame(map.bodies[placing.upper].body, dynamics) * placing.bend, axis);
    // An arm held straight does not say which way it bends; the model does: no
    // elbow bends backwards, and one on the line goes its way.
    if (off < kBent && bend.norm() > kNowhere) {
      out -= std::min(0.0, out.dot(bend)) / bend.squaredNorm() * bend;
    }
    out += kStraight * bend;
  }
  if (out.norm() < kNowhere) return;
  BendLimb(origin, placings[placing.limb].length, placing.length, place, out,
           &elbow, &(*places)[role]);
}

}  // namespace

Vector3d PointPlace(const BodyMap& map, const RolePoint& point,
                    const Dynamics& dynamics) {
  const int body = map.bodies[point.mapped].body;
  return Eigen::Map<const Vector3d>(dynamics.data().xpos + 3 * body) +
         Frame(body, dynamics) * point.position;
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
          PlaceHand(placings, map, role,
                    hips + map.scale * (source[role] -
                                        (source[left] + source[right]) / 2),
                    *dynamics, &places);
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
