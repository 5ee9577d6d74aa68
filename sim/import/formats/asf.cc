#include <map>
#include <numbers>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/status_macros.h"
#include "sim/import/formats/asf_amc.h"
#include "sim/import/formats/asf_text.h"
#include "sim/import/formats/text_lines.h"
#include "sim/import/formats/unique_names.h"

namespace sinew::import {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

// `unit`: rad per unit of angle.
Quaterniond RotationOf(const AsfAngles& angles, double unit) {
  Quaterniond rotation = Quaterniond::Identity();
  for (int i = 0; i < 3; ++i) {
    rotation = Eigen::AngleAxisd(angles.value[i] * unit,
                                 Vector3d::Unit(angles.axis[i])) *
               rotation;
  }
  return rotation;
}

// Makes one skeleton of the bones of a file.
class Builder {
 public:
  Builder(const AsfText& text, absl::string_view source)
      : text_(text), source_(source) {}

  // Finds the children of each bone.
  absl::Status Connect() {
    std::map<std::string, int> index;
    for (size_t i = 0; i < text_.bones.size(); ++i) {
      if (!index.emplace(text_.bones[i].name, static_cast<int>(i)).second) {
        return Error("bones of different names, root aside",
                     absl::StrCat(text_.bones[i].name, " twice"));
      }
    }
    children_.resize(text_.bones.size());
    std::vector<bool> has_parent(text_.bones.size());
    for (const AsfLink& link : text_.links) {
      const auto parent = index.find(link.parent);
      const auto child = index.find(link.child);
      if (parent == index.end() || child == index.end()) {
        return LineError(
            source_, link.line,
            absl::StrCat(
                "expected a bone of :bonedata, found ",
                Quoted(parent == index.end() ? link.parent : link.child)));
      }
      if (child->second == 0 || has_parent[child->second]) {
        return LineError(source_, link.line,
                         absl::StrCat("expected one parent for each bone and "
                                      "none for the root, found another for ",
                                      Quoted(link.child)));
      }
      has_parent[child->second] = true;
      children_[parent->second].push_back(child->second);
    }
    return absl::OkStatus();
  }

  // Joints in the order of the hierarchy, parents first.
  absl::StatusOr<AsfSkeleton> Build() {
    asf_.root_position = text_.root_position;
    asf_.length = text_.length;
    asf_.angles_in_degrees = text_.angles_in_degrees;
    const double unit = text_.angles_in_degrees ? std::numbers::pi / 180 : 1;
    for (const AsfTextBone& bone : text_.bones) {
      asf_.bones.push_back(
          {bone.name, -1, RotationOf(bone.axis, unit), bone.channels});
    }
    UniqueNames names;
    for (const AsfTextBone& bone : text_.bones) names.Take(bone.name);
    std::vector<std::pair<int, int>> open = {{0, -1}};  // bone, parent joint
    while (!open.empty()) {
      const auto [bone, parent] = open.back();
      open.pop_back();
      AddJoints(bone, parent, names);
      const std::vector<int>& children = children_[bone];
      for (auto child = children.rbegin(); child != children.rend(); ++child) {
        open.emplace_back(*child, asf_.bones[bone].joint);
      }
    }
    for (const AsfBone& bone : asf_.bones) {
      if (bone.joint < 0) {
        return Error("a :hierarchy that leads from the root to every bone",
                     absl::StrCat(bone.name, " apart"));
      }
    }
    return std::move(asf_);
  }

 private:
  absl::Status Error(absl::string_view expected, absl::string_view found) {
    return LineError(
        source_, text_.num_lines,
        absl::StrCat("expected ", expected, ", found ", Quoted(found)));
  }

  // The joint at the start of a bone and, of a last one, that at its end.
  void AddJoints(int bone, int parent, UniqueNames& names) {
    std::vector<SourceJoint>& joints = asf_.skeleton.joints;
    asf_.bones[bone].joint = static_cast<int>(joints.size());
    joint_bone_.push_back(bone);
    const Vector3d start = parent < 0 ? Vector3d(0, 0, 0)
                                      : EndOf(text_.bones[joint_bone_[parent]]);
    joints.push_back({text_.bones[bone].name, parent, start});
    if (!children_[bone].empty()) return;
    joint_bone_.push_back(bone);
    joints.push_back({names.Take(absl::StrCat(text_.bones[bone].name, "_end")),
                      asf_.bones[bone].joint, EndOf(text_.bones[bone]),
                      /*is_end=*/true});
  }

  static Vector3d EndOf(const AsfTextBone& bone) {
    return bone.direction * bone.length;
  }

  const AsfText& text_;
  const absl::string_view source_;
  std::vector<std::vector<int>> children_;  // [bones]
  std::vector<int> joint_bone_;             // [joints]
  AsfSkeleton asf_;
};

}  // namespace

absl::StatusOr<AsfSkeleton> ParseAsf(absl::string_view bytes,
                                     absl::string_view source) {
  SINEW_RETURN_IF_ERROR(CheckFileSize(bytes, kAsfMaxBytes, source));
  SINEW_ASSIGN_OR_RETURN(AsfText text, ReadAsfText(bytes, source));
  Builder builder(text, source);
  SINEW_RETURN_IF_ERROR(builder.Connect());
  return builder.Build();
}

}  // namespace sinew::import
