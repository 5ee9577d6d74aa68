#ifndef SINEW_SIM_IMPORT_RETARGET_ROLE_TRACK_H_
#define SINEW_SIM_IMPORT_RETARGET_ROLE_TRACK_H_

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "proto/sinew/v1/skeleton_map.pb.h"
#include "sim/import/formats/source_clip.h"
#include "sim/import/retarget/source_track.h"

namespace sinew::import {

// A clip by roles, free of its skeleton's spelling, rest pose and joints in
// between: what every source looks like from here on.
//
// Rotations are those from standing upright, looking along +x, to the frame: a
// role's is the identity where the body stands so. Joints without a role move
// with their parents, so a spine of four turns the role of its last joint.
struct RoleTrack {
  double rate = 0;  // frames per second
  bool loops = false;
  Cycle cycle;  // about the root role
  double retiming = 1;

  std::vector<std::string> roles;  // [0] is "root"; parents before children
  std::vector<int> parent;         // [roles] role above, -1: root
  std::vector<bool> turns;         // [roles] false: moves with its parent
  // [roles] in the standing pose: looking along +x, z up, root at the origin.
  std::vector<Eigen::Vector3d> standing;
  // [frames][roles] world.
  std::vector<std::vector<Eigen::Vector3d>> position;
  std::vector<std::vector<Eigen::Quaterniond>> rotation;

  int frames() const { return static_cast<int>(position.size()); }
  int Find(absl::string_view role) const;  // -1: absent
};

// Gives the joints of a track their roles. Ends that the map does not name are
// found: the end below a toe (or ankle), head or hand (or elbow).
//
// Which way the rest pose looks is found from its hips, legs and trunk; within
// kLeastRestTurn of an axis it is that axis. The arms may point anywhere.
// INVALID_ARGUMENT: the map does not fit the skeleton (CheckMapFits); the hips
// or the legs of the rest pose have no extent.
absl::StatusOr<RoleTrack> MakeRoleTrack(const SourceTrack& track,
                                        const SourceSkeleton& skeleton,
                                        const v1::SkeletonMap& map);

// rad
inline constexpr double kLeastRestTurn = 0.35;

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_RETARGET_ROLE_TRACK_H_
