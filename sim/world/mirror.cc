#include "sim/world/mirror.h"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/string_view.h"
#include "common/check.h"
#include "common/status_macros.h"
#include "sim/character/mirror_joints.h"

namespace sinew::world {
namespace {

using character::JointInfo;

// Of the cosine of half an angle: 0.1 degrees.
constexpr double kFrameTolerance = 4e-7;

using Partner = character::MirrorPartner;
using Partners = character::MirrorPartners;

// Radians; an end that there is not is the same one.
bool SameEnd(double a, double b) { return a == b || std::abs(a - b) < 1e-6; }

// Targets are limited to it.
bool SameRange(const JointInfo& a, const JointInfo& b, float sign) {
  return SameEnd(a.lower, sign > 0 ? b.lower : -b.upper) &&
         SameEnd(a.upper, sign > 0 ? b.upper : -b.lower);
}

bool SameDrive(const JointInfo& a, const JointInfo& b, float sign) {
  return a.stiffness == b.stiffness && a.damping == b.damping &&
         a.torque_limit == b.torque_limit && a.action_scale == b.action_scale &&
         a.default_position == sign * b.default_position;
}

// FAILED_PRECONDITION if the mirrored body would be another one.
absl::Status CheckDrives(const TrackingTask& task, const RowMirror& mirror) {
  const character::Character& character = task.character();
  for (size_t i = 0; i < mirror.source.size(); ++i) {
    const JointInfo& joint = character.joints()[i];
    const JointInfo& partner = character.joints()[mirror.source[i]];
    if (SameRange(joint, partner, mirror.sign[i]) &&
        SameDrive(joint, partner, mirror.sign[i]) &&
        task.actuation().SameDrive(static_cast<int>(i), mirror.source[i])) {
      continue;
    }
    return absl::FailedPreconditionError(absl::StrCat(
        "character ", character.name(), ": mirror_joints: expected ",
        joint.name, " and ", partner.name,
        " to have equal ranges, gains, limits, ",
        "default positions, action scales and drives, found others"));
  }
  return absl::OkStatus();
}

// Sign of one of x, y, z under the mirror.
float AxisSign(absl::string_view axis) { return axis == "y" ? -1 : 1; }

// Entry "RC" of a rotation matrix: row and column each turn with their axis.
float EntrySign(const std::string& entry) {
  return (entry[0] == '1' ? -1.F : 1.F) * (entry[1] == '1' ? -1.F : 1.F);
}

// The name and sign that an observation's column takes its number from.
Partner MirrorColumn(const std::string& name, const Partners& joints,
                     const Partners& bodies) {
  // E.g. "self/joint_position/left_knee", "reference+1/root_position/x".
  std::vector<std::string> parts = absl::StrSplit(name, '/');
  const std::string last = parts.back();
  const std::string& quantity =
      parts.size() > 1 && parts[0] != "previous_target" ? parts[1] : parts[0];
  const auto swap = [&](std::string& part, const Partners& partners) {
    const auto partner = partners.find(part);
    if (partner == partners.end()) return 1.0F;
    part = partner->second.name;
    return partner->second.sign;
  };
  float sign = 1;
  if (quantity == "root_angular_velocity") {
    sign = -AxisSign(last);
  } else if (quantity == "root_rotation") {
    sign = EntrySign(last);
  } else if (quantity == "joint_position" || quantity == "joint_velocity" ||
             quantity == "previous_target") {
    sign = swap(parts.back(), joints);
  } else if (quantity == "rotation" || quantity == "rotation_difference") {
    swap(parts[2], bodies);
    sign = EntrySign(last);
  } else if (quantity == "angular_velocity" ||
             quantity == "angular_velocity_difference") {
    swap(parts[2], bodies);
    sign = -AxisSign(last);
  } else if (quantity == "body_position" || quantity == "position" ||
             quantity == "position_difference" ||
             quantity == "linear_velocity" ||
             quantity == "linear_velocity_difference") {
    swap(parts[2], bodies);
    sign = AxisSign(last);
  } else if (quantity == "contact") {
    swap(parts.back(), bodies);
  } else if (quantity == "root_position" ||
             quantity == "root_linear_velocity") {
    sign = AxisSign(last);
  } else {
    SINEW_CHECK(quantity == "root_height") << "unknown column " << name;
  }
  std::string source = parts[0];
  for (size_t i = 1; i < parts.size(); ++i) {
    absl::StrAppend(&source, "/", parts[i]);
  }
  return {source, sign};
}

// True for blocks with rotations of bodies other than the root.
bool ShowsFrames(int block) {
  return block == v1::Observation::BLOCK_REFERENCE_BODIES ||
         block == v1::Observation::BLOCK_SELF_BODIES;
}

// FAILED_PRECONDITION if the frames of mirrored bodies are no mirror images at
// rest, so that S R S would not be the partner's rotation, and a block shows
// it.
absl::Status CheckFrames(const TrackingTask& task, const Partners& bodies) {
  const auto& blocks = task.recipe().task().observation().blocks();
  const auto block = std::find_if(blocks.begin(), blocks.end(), ShowsFrames);
  if (block == blocks.end()) return absl::OkStatus();
  const mjModel* model = task.character().model();
  const character::DataPtr data(mj_makeData(model));
  mj_kinematics(model, data.get());
  for (int column : task.character().tracked()) {
    const int body = column + 1;
    const std::string name = mj_id2name(model, mjOBJ_BODY, body);
    const auto found = bodies.find(name);
    const std::string partner =
        found == bodies.end() ? name : found->second.name;
    const int other = mj_name2id(model, mjOBJ_BODY, partner.c_str());
    // S R S of a quaternion: x and z change sign.
    double cosine = 0;
    for (int i = 0; i < 4; ++i) {
      cosine += (i % 2 == 1 ? -1 : 1) * data->xquat[4 * body + i] *
                data->xquat[4 * other + i];
    }
    if (std::abs(cosine) > 1 - kFrameTolerance) continue;
    return absl::FailedPreconditionError(absl::StrCat(
        "character ", task.character().name(), ": mirror_bodies: expected ",
        "frames of ", name, " and ", partner, " that mirror each other at ",
        "rest, which ", v1::Observation::Block_Name(*block),
        " needs, found others"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<SegmentMirror> MakeMirror(const TrackingTask& task) {
  const v1::Character& proto = task.character().proto();
  const Partners joints = character::MakePartners(proto.mirror_joints());
  const Partners bodies = character::MakePartners(proto.mirror_bodies());
  SegmentMirror mirror;
  SINEW_ASSIGN_OR_RETURN(mirror.action,
                         character::MirrorJoints(task.character()));
  SINEW_RETURN_IF_ERROR(CheckDrives(task, mirror.action));
  SINEW_RETURN_IF_ERROR(CheckFrames(task, bodies));
  const std::vector<std::string> names = task.ObservationNames();
  std::map<std::string, int> index;
  for (size_t i = 0; i < names.size(); ++i) {
    index.emplace(names[i], static_cast<int>(i));
  }
  for (const std::string& name : names) {
    const Partner partner = MirrorColumn(name, joints, bodies);
    mirror.observation.source.push_back(index.at(partner.name));
    mirror.observation.sign.push_back(partner.sign);
  }
  SINEW_RETURN_IF_ERROR(CheckRowMirror(mirror.observation));
  return mirror;
}

}  // namespace sinew::world
