#include "sim/import/formats/source_clip_proto.h"

#include <cmath>
#include <set>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/status_macros.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

constexpr double kNormTolerance = 1e-6;

absl::Status Error(absl::string_view source, absl::string_view field,
                   absl::string_view expected) {
  return absl::InvalidArgumentError(
      absl::StrCat(source, ": clip: ", field, ": expected ", expected));
}

absl::Status ReadSkeleton(const v1::SourceClip& proto, absl::string_view source,
                          SourceSkeleton* skeleton) {
  std::set<std::string> names;
  for (const v1::SourceJoint& joint : proto.joints()) {
    const int index = static_cast<int>(skeleton->joints.size());
    const bool is_root = index == 0;
    if ((joint.parent() == -1) != is_root || joint.parent() < -1 ||
        joint.parent() >= index) {
      return Error(source, "parent", "a joint before it");
    }
    if (!names.insert(joint.name()).second) {
      return Error(source, "name", "a new one");
    }
    if (joint.offset_size() != 3) return Error(source, "offset", "3 numbers");
    const Eigen::Vector3d offset(joint.offset().data());
    if (!offset.allFinite() || (is_root && !offset.isZero(0))) {
      return Error(source, "offset", "finite numbers, zero at the root");
    }
    skeleton->joints.push_back({.name = joint.name(),
                                .parent = joint.parent(),
                                .offset = offset,
                                .is_end = joint.is_end()});
  }
  return names.empty() ? Error(source, "joints", "at least one")
                       : absl::OkStatus();
}

absl::Status ReadPoses(const v1::SourceClip& proto, absl::string_view source,
                       SourceClip* clip) {
  const int frames = proto.times_size();
  const int64_t joints = proto.joints_size();
  if (frames < 2 || proto.root_positions_size() != int64_t{3} * frames ||
      proto.rotations_size() != 4 * joints * frames) {
    return Error(source, "times, root_positions, rotations",
                 "at least 2 frames, and as many numbers as those need");
  }
  for (int frame = 0; frame < frames; ++frame) {
    SourcePose pose;
    pose.time = proto.times(frame);
    const double before = frame == 0 ? 0 : proto.times(frame - 1);
    if (!(frame == 0 ? pose.time == 0
                     : pose.time > before && pose.time <= kMaxClipSeconds)) {
      return Error(source, "times", "numbers that rise from 0");
    }
    pose.root_position =
        Eigen::Vector3d(proto.root_positions().data() + 3 * frame);
    if (!pose.root_position.allFinite()) {
      return Error(source, "root_positions", "finite numbers");
    }
    for (int64_t joint = 0; joint < joints; ++joint) {
      const Eigen::Quaterniond rotation = motion::FromWxyz(
          proto.rotations().data() + 4 * (frame * joints + joint));
      if (!(std::abs(rotation.norm() - 1) <= kNormTolerance)) {
        return Error(source, "rotations", "unit quaternions");
      }
      pose.rotation.push_back(rotation);
    }
    clip->poses.push_back(std::move(pose));
  }
  return absl::OkStatus();
}

}  // namespace

v1::SourceClip ToProto(const SourceClip& clip) {
  v1::SourceClip proto;
  for (const SourceJoint& joint : clip.skeleton.joints) {
    v1::SourceJoint& written = *proto.add_joints();
    written.set_name(joint.name);
    written.set_parent(joint.parent);
    for (const double value : joint.offset) written.add_offset(value);
    written.set_is_end(joint.is_end);
  }
  for (const SourcePose& pose : clip.poses) {
    proto.add_times(pose.time);
    for (const double value : pose.root_position) {
      proto.add_root_positions(value);
    }
    for (const Eigen::Quaterniond& rotation : pose.rotation) {
      double wxyz[4];
      motion::ToWxyz(rotation, wxyz);
      for (const double value : wxyz) proto.add_rotations(value);
    }
  }
  *proto.mutable_facts() = clip.facts;
  for (const std::string& warning : clip.warnings) proto.add_warnings(warning);
  return proto;
}

absl::StatusOr<SourceClip> FromProto(const v1::SourceClip& proto,
                                     absl::string_view source) {
  SourceClip clip;
  SINEW_RETURN_IF_ERROR(ReadSkeleton(proto, source, &clip.skeleton));
  SINEW_RETURN_IF_ERROR(ReadPoses(proto, source, &clip));
  clip.facts = proto.facts();
  clip.warnings.assign(proto.warnings().begin(), proto.warnings().end());
  return clip;
}

}  // namespace sinew::import
