#include "sim/import/retarget/role_track.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/status_macros.h"
#include "sim/import/maps/skeleton_maps.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

// Ends shorter than this share of a leg point nowhere; a hand is no longer
// than that share of the forearm.
constexpr double kLeastEnd = 0.01;
constexpr double kLongestHand = 0.9;

// Rotations and positions of all joints in the standing pose, in the rest
// pose's world.
struct Standing {
  std::vector<Quaterniond> rotation;
  std::vector<Vector3d> position;
};

Quaterniond FromDegrees(const v1::JointRole& joint) {
  return motion::Exp(Vector3d(joint.rest_degrees(0), joint.rest_degrees(1),
                              joint.rest_degrees(2)) *
                     (std::numbers::pi / 180));
}

Standing Stand(const SourceSkeleton& skeleton, const v1::SkeletonMap& map) {
  std::map<int, Quaterniond> given;
  for (const v1::JointRole& joint : map.joints()) {
    if (joint.rest_degrees_size() != 3) continue;
    given[FindMapped(skeleton, joint.source())] = FromDegrees(joint);
  }
  Standing standing;
  for (size_t j = 0; j < skeleton.joints.size(); ++j) {
    const SourceJoint& joint = skeleton.joints[j];
    const bool root = joint.parent < 0;
    const auto turn = given.find(static_cast<int>(j));
    standing.rotation.push_back(turn != given.end() ? turn->second
                                : root              ? Quaterniond::Identity()
                                       : standing.rotation[joint.parent]);
    standing.position.push_back(
        root ? Vector3d::Zero()
             : Vector3d(standing.position[joint.parent] +
                        standing.rotation[joint.parent] * joint.offset));
  }
  return standing;
}

// Joints by role while the track is in the making.
class Roles {
 public:
  Roles(const SourceSkeleton& skeleton, const v1::SkeletonMap& map)
      : skeleton_(skeleton) {
    for (const v1::JointRole& joint : map.joints()) {
      joints_[joint.role()] = FindMapped(skeleton, joint.source());
    }
    AddEnds();
  }

  int joint(const std::string& role) const {
    const auto found = joints_.find(role);
    return found == joints_.end() ? -1 : found->second;
  }

  // The role of a joint; empty: none.
  std::string role(int joint) const {
    for (const auto& [role, j] : joints_) {
      if (j == joint) return role;
    }
    return "";
  }

 private:
  // The first end below a joint that is long enough; -1: none.
  int EndBelow(int joint, double shortest, double longest) const {
    if (joint < 0) return -1;
    for (size_t i = joint + 1; i < skeleton_.joints.size(); ++i) {
      const SourceJoint& end = skeleton_.joints[i];
      const double length = end.offset.norm();
      if (end.parent == joint && end.is_end && length > shortest &&
          length < longest) {
        return static_cast<int>(i);
      }
    }
    return -1;
  }

  void AddEnd(const std::string& role, int joint) {
    if (joint >= 0) joints_.emplace(role, joint);
  }

  void AddEnds() {
    const double leg = skeleton_.joints[joint("left_knee")].offset.norm() +
                       skeleton_.joints[joint("left_ankle")].offset.norm();
    const double shortest = kLeastEnd * leg;
    AddEnd("head_end", EndBelow(joint("head"), shortest, leg));
    for (const std::string side : {"left_", "right_"}) {
      const bool has_toe = joint(side + "toe") >= 0;
      AddEnd(
          side + (has_toe ? "toe_end" : "toe"),
          EndBelow(joint(side + (has_toe ? "toe" : "ankle")), shortest, leg));
      if (joint(side + "wrist") < 0) {
        AddEnd(side + "wrist", EndBelow(joint(side + "elbow"), shortest, leg));
        continue;
      }
      const double forearm =
          skeleton_.joints[joint(side + "wrist")].offset.norm();
      AddEnd(side + "hand_end",
             EndBelow(joint(side + "wrist"), shortest, kLongestHand * forearm));
    }
  }

  const SourceSkeleton& skeleton_;
  std::map<std::string, int> joints_;
};

// The signed axes nearest to three directions, if they are near.
Matrix3d Snap(const Matrix3d& basis) {
  Matrix3d axes = Matrix3d::Zero();
  for (int column = 0; column < 3; ++column) {
    int row = 0;
    basis.col(column).cwiseAbs().maxCoeff(&row);
    axes(row, column) = basis(row, column) < 0 ? -1 : 1;
  }
  const bool rotation = std::abs(axes.determinant() - 1) < 0.5;
  const bool near =
      rotation &&
      Eigen::AngleAxisd(Matrix3d(axes.transpose() * basis)).angle() <
          kLeastRestTurn;
  return near ? axes : basis;
}

// Forward, left and up of the standing pose, as columns.
absl::StatusOr<Matrix3d> FindBasis(const Roles& roles,
                                   const Standing& standing) {
  const auto at = [&](const std::string& role) -> const Vector3d& {
    return standing.position[roles.joint(role)];
  };
  const Vector3d across = at("left_hip") - at("right_hip");
  const Vector3d hips = (at("left_hip") + at("right_hip")) / 2;
  const Vector3d legs = hips - (at("left_ankle") + at("right_ankle")) / 2;
  if (across.norm() < 1e-6 || legs.norm() < 1e-6) {
    return absl::InvalidArgumentError(
        "skeleton: expected a rest pose whose hips lie apart and whose ankles "
        "lie below them, found no extent");
  }
  Vector3d up = legs.normalized();
  for (const char* role : {"head", "neck", "chest"}) {
    if (roles.joint(role) < 0) continue;
    const Vector3d trunk = at(role) - hips;
    if (trunk.norm() > 1e-6) up += trunk.normalized();
    break;
  }
  const Vector3d left = across.normalized();
  up -= up.dot(left) * left;
  if (up.norm() < 0.1) {
    return absl::InvalidArgumentError(
        "skeleton: expected legs across the line between the hips in the rest "
        "pose, found them along it; give the map rest_degrees");
  }
  up.normalize();
  Matrix3d basis;
  basis << left.cross(up), left, up;
  return Snap(basis);
}

// Roles, parents and standing positions.
void AddRoles(const SourceSkeleton& skeleton, const Roles& roles,
              const Standing& standing, const Matrix3d& basis,
              std::vector<int>* joints, RoleTrack* track) {
  const Vector3d origin = standing.position[roles.joint("root")];
  for (const std::string& role : AllRoles()) {
    const int joint = roles.joint(role);
    if (joint < 0) continue;
    int above = skeleton.joints[joint].parent;
    while (above >= 0 && roles.role(above).empty()) {
      above = skeleton.joints[above].parent;
    }
    const int parent = above < 0 ? 0 : track->Find(roles.role(above));
    track->parent.push_back(track->roles.empty() ? -1 : std::max(parent, 0));
    track->roles.push_back(role);
    track->turns.push_back(!skeleton.joints[joint].is_end);
    track->standing.push_back(basis.transpose() *
                              (standing.position[joint] - origin));
    joints->push_back(joint);
  }
}

}  // namespace

int RoleTrack::Find(absl::string_view role) const {
  const auto found = std::find(roles.begin(), roles.end(), role);
  return found == roles.end() ? -1 : static_cast<int>(found - roles.begin());
}

absl::StatusOr<RoleTrack> MakeRoleTrack(const SourceTrack& track,
                                        const SourceSkeleton& skeleton,
                                        const v1::SkeletonMap& map) {
  SINEW_RETURN_IF_ERROR(CheckMapFits(map, skeleton));
  const Standing standing = Stand(skeleton, map);
  const Roles roles(skeleton, map);
  SINEW_ASSIGN_OR_RETURN(const Matrix3d basis, FindBasis(roles, standing));
  RoleTrack result;
  result.rate = track.rate;
  result.loops = track.loops;
  result.retiming = track.retiming;
  std::vector<int> joints;
  AddRoles(skeleton, roles, standing, basis, &joints, &result);
  std::vector<Quaterniond> from_standing;
  for (const int joint : joints) {
    from_standing.push_back(standing.rotation[joint].conjugate() *
                            Quaterniond(basis));
  }
  for (int t = 0; t < track.frames(); ++t) {
    const std::vector<Quaterniond> world =
        WorldRotations(skeleton, track.rotation[t]);
    const std::vector<Vector3d> place =
        WorldPositions(skeleton, track.root_position[t], track.rotation[t]);
    std::vector<Vector3d>& positions = result.position.emplace_back();
    std::vector<Quaterniond>& rotations = result.rotation.emplace_back();
    for (size_t r = 0; r < joints.size(); ++r) {
      positions.push_back(place[joints[r]]);
      rotations.push_back(world[joints[r]] * from_standing[r]);
    }
  }
  result.cycle =
      MovePivot(track.cycle, track.root_position[0], result.position[0][0]);
  return result;
}

}  // namespace sinew::import
