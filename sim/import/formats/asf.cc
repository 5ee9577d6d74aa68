#include <algorithm>
#include <map>
#include <numbers>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/status_macros.h"
#include "sim/import/formats/asf_amc.h"
#include "sim/import/formats/text_lines.h"
#include "sim/import/formats/unique_names.h"

namespace sinew::import {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr size_t kMaxBones = 2000;

// Angles about three axes, the first one first, in the file's unit.
struct Angles {
  double value[3] = {0, 0, 0};
  int axis[3] = {0, 1, 2};

  Quaterniond Rotation(double unit) const {
    Quaterniond rotation = Quaterniond::Identity();
    for (int i = 0; i < 3; ++i) {
      rotation = Eigen::AngleAxisd(value[i] * unit, Vector3d::Unit(axis[i])) *
                 rotation;
    }
    return rotation;
  }
};

// A bone as written.
struct Bone {
  std::string name;
  Vector3d direction = Vector3d::Zero();
  double length = -1;
  Angles axis;
  std::vector<AsfChannel> channels;
};

// One child in the hierarchy.
struct Link {
  int64_t line;
  std::string parent;
  std::string child;
};

class Parser {
 public:
  Parser(absl::string_view bytes, absl::string_view source)
      : lines_(bytes), source_(source) {
    bones_.emplace_back();
    bones_[0].name = "root";
    bones_[0].length = 0;
  }

  absl::StatusOr<AsfSkeleton> Parse() {
    while (lines_.Next()) {
      if (lines_.text().empty() || lines_.text()[0] == '#') continue;
      SINEW_RETURN_IF_ERROR(ReadLine());
    }
    if (in_bone_) return Error("\"end\" of the last bone", "");
    if (bones_.size() < 2) return Error("a section :bonedata", "");
    SINEW_RETURN_IF_ERROR(Connect());
    return Build();
  }

 private:
  absl::Status Error(absl::string_view expected, absl::string_view found) {
    return LineError(source_, lines_.number(),
                     absl::StrCat("expected ", expected, ", found ",
                                  found.empty() ? "none" : Quoted(found)));
  }

  absl::Status ReadLine() {
    absl::string_view rest = lines_.text();
    const std::string word = absl::AsciiStrToLower(TakeWord(&rest));
    if (word[0] == ':') {
      if (in_bone_) return Error("\"end\" of a bone", word);
      section_ = word;
      return absl::OkStatus();
    }
    if (section_ == ":units") return ReadUnit(word, rest);
    if (section_ == ":root") return ReadRoot(word, rest);
    if (section_ == ":bonedata") return ReadBone(word, rest);
    if (section_ == ":hierarchy") return ReadLinks(rest);
    if (section_.empty()) return Error("a section of an ASF file", word);
    return absl::OkStatus();
  }

  absl::StatusOr<double> Number(absl::string_view* rest) {
    const absl::StatusOr<double> value = ParseNumber(TakeWord(rest));
    if (value.ok()) return value;
    return LineError(source_, lines_.number(), value.status().message());
  }

  absl::Status ReadVector(absl::string_view rest, Vector3d& vector) {
    for (int i = 0; i < 3; ++i) {
      SINEW_ASSIGN_OR_RETURN(vector[i], Number(&rest));
    }
    return absl::OkStatus();
  }

  // Three letters, each of x, y and z once.
  absl::Status ReadOrder(absl::string_view word, Angles& angles) {
    bool seen[3] = {false, false, false};
    for (size_t i = 0; i < 3 && word.size() == 3; ++i) {
      const size_t axis =
          absl::string_view("xyz").find(absl::ascii_tolower(word[i]));
      if (axis == absl::string_view::npos || seen[axis]) break;
      seen[axis] = true;
      angles.axis[i] = static_cast<int>(axis);
    }
    if (seen[0] && seen[1] && seen[2]) return absl::OkStatus();
    return Error("an order of axes like XYZ", word);
  }

  absl::Status ReadChannels(absl::string_view rest, bool is_root,
                            std::vector<AsfChannel>& channels) {
    channels.clear();
    for (absl::string_view word = TakeWord(&rest); !word.empty();
         word = TakeWord(&rest)) {
      const char kind = absl::ascii_tolower(word[0]);
      const size_t axis =
          word.size() == 2
              ? absl::string_view("xyz").find(absl::ascii_tolower(word[1]))
              : absl::string_view::npos;
      const AsfChannel channel = {kind == 't', static_cast<int>(axis)};
      const bool is_new = std::none_of(
          channels.begin(), channels.end(), [&channel](const AsfChannel& c) {
            return c.is_position == channel.is_position &&
                   c.axis == channel.axis;
          });
      if (axis == absl::string_view::npos || !is_new ||
          !(kind == 'r' || (kind == 't' && is_root))) {
        return Error(is_root ? "each of TX TY TZ RX RY RZ at most once"
                             : "each of rx ry rz at most once",
                     word);
      }
      channels.push_back(channel);
    }
    return absl::OkStatus();
  }

  absl::Status ReadUnit(const std::string& key, absl::string_view rest) {
    if (key == "length") {
      SINEW_ASSIGN_OR_RETURN(const double length, Number(&rest));
      if (!(length >= 1e-6)) return Error("a length > 0", lines_.text());
      asf_.length = length;
    } else if (key == "angle") {
      const absl::string_view unit = TakeWord(&rest);
      asf_.angles_in_degrees = absl::StartsWithIgnoreCase(unit, "deg");
      if (!asf_.angles_in_degrees && !absl::StartsWithIgnoreCase(unit, "rad")) {
        return Error("an angle in deg or rad", unit);
      }
    }
    return absl::OkStatus();
  }

  absl::Status ReadRoot(const std::string& key, absl::string_view rest) {
    Bone& root = bones_[0];
    if (key == "order") return ReadChannels(rest, true, root.channels);
    if (key == "axis") return ReadOrder(TakeWord(&rest), root.axis);
    if (key == "position") return ReadVector(rest, asf_.root_position);
    if (key == "orientation") {
      for (double& value : root.axis.value) {
        SINEW_ASSIGN_OR_RETURN(value, Number(&rest));
      }
    }
    return absl::OkStatus();
  }

  absl::Status ReadBone(const std::string& key, absl::string_view rest) {
    if (!in_bone_) {
      if (key != "begin") return Error("\"begin\" of a bone", key);
      if (bones_.size() > kMaxBones) {
        return Error(absl::StrCat("at most ", kMaxBones, " bones"), "more");
      }
      in_bone_ = true;
      bones_.emplace_back();
      return absl::OkStatus();
    }
    Bone& bone = bones_.back();
    if (key == "end") return EndBone();
    if (key == "name") {
      if (!bone.name.empty()) return Error("one name a bone", rest);
      absl::StatusOr<std::string> name = ParseName(rest);
      if (!name.ok()) {
        return LineError(source_, lines_.number(), name.status().message());
      }
      bone.name = *std::move(name);
    } else if (key == "direction") {
      return ReadVector(rest, bone.direction);
    } else if (key == "length") {
      SINEW_ASSIGN_OR_RETURN(bone.length, Number(&rest));
      if (bone.length < 0) return Error("a length >= 0", lines_.text());
    } else if (key == "axis") {
      for (double& value : bone.axis.value) {
        SINEW_ASSIGN_OR_RETURN(value, Number(&rest));
      }
      const absl::string_view order = TakeWord(&rest);
      return order.empty() ? absl::OkStatus() : ReadOrder(order, bone.axis);
    } else if (key == "dof") {
      return ReadChannels(rest, false, bone.channels);
    }
    return absl::OkStatus();
  }

  absl::Status EndBone() {
    const Bone& bone = bones_.back();
    in_bone_ = false;
    if (bone.name.empty()) return Error("a bone with a name", "");
    if (bone.length < 0) {
      return Error(absl::StrCat("a length of bone ", Quoted(bone.name)), "");
    }
    return absl::OkStatus();
  }

  absl::Status ReadLinks(absl::string_view rest) {
    absl::string_view line = lines_.text();
    const absl::string_view parent = TakeWord(&line);
    for (absl::string_view child = TakeWord(&rest); !child.empty();
         child = TakeWord(&rest)) {
      links_.push_back(
          {lines_.number(), std::string(parent), std::string(child)});
    }
    return absl::OkStatus();
  }

  // Fills children_ from links_.
  absl::Status Connect() {
    std::map<std::string, int> index;
    for (size_t i = 0; i < bones_.size(); ++i) {
      if (!index.emplace(bones_[i].name, static_cast<int>(i)).second) {
        return Error("bones of different names, root aside",
                     absl::StrCat(bones_[i].name, " twice"));
      }
    }
    children_.resize(bones_.size());
    std::vector<bool> has_parent(bones_.size());
    for (const Link& link : links_) {
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
    const double unit = asf_.angles_in_degrees ? std::numbers::pi / 180 : 1;
    for (const Bone& bone : bones_) {
      asf_.bones.push_back(
          {bone.name, -1, bone.axis.Rotation(unit), bone.channels});
    }
    UniqueNames names;
    for (const Bone& bone : bones_) names.Take(bone.name);
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

  // The joint at the start of a bone and, of a last one, that at its end.
  void AddJoints(int bone, int parent, UniqueNames& names) {
    std::vector<SourceJoint>& joints = asf_.skeleton.joints;
    asf_.bones[bone].joint = static_cast<int>(joints.size());
    joint_bone_.push_back(bone);
    const Vector3d start =
        parent < 0 ? Vector3d(0, 0, 0) : EndOf(bones_[joint_bone_[parent]]);
    joints.push_back({bones_[bone].name, parent, start});
    if (!children_[bone].empty()) return;
    joint_bone_.push_back(bone);
    joints.push_back({names.Take(absl::StrCat(bones_[bone].name, "_end")),
                      asf_.bones[bone].joint, EndOf(bones_[bone]),
                      /*is_end=*/true});
  }

  static Vector3d EndOf(const Bone& bone) {
    return bone.direction * bone.length;
  }

  TextLines lines_;
  const absl::string_view source_;
  std::string section_;
  bool in_bone_ = false;
  std::vector<Bone> bones_;  // [0]: the root
  std::vector<Link> links_;
  std::vector<std::vector<int>> children_;  // [bones]
  std::vector<int> joint_bone_;             // [joints]
  AsfSkeleton asf_;
};

}  // namespace

absl::StatusOr<AsfSkeleton> ParseAsf(absl::string_view bytes,
                                     absl::string_view source) {
  if (static_cast<int64_t>(bytes.size()) > kAsfMaxBytes) {
    return absl::ResourceExhaustedError(
        absl::StrCat(source, ": expected at most ", kAsfMaxBytes,
                     " bytes, found ", bytes.size()));
  }
  return Parser(bytes, source).Parse();
}

}  // namespace sinew::import
