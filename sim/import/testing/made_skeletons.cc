#include "sim/import/testing/made_skeletons.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "sim/motion/rotation.h"

namespace sinew::import::testing {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kRate = 60;
constexpr double kSeconds = 2;

// A joint as it is standing with the arms down, looking along +x.
struct Part {
  std::string name;  // of sided parts without the side
  char side;         // 'L', 'R' or 'M'
  int parent;
  Vector3d offset;
  bool is_end;
};

std::vector<Part> Parts(int extra_spine) {
  std::vector<Part> parts = {{"Hips", 'M', -1, {0, 0, 0}, false},
                             {"Spine", 'M', 0, {0, 0, 0.08}, false}};
  const double share = 1.0 / (extra_spine + 1);
  for (int i = 0; i < extra_spine; ++i) {
    parts.push_back({absl::StrCat("Extra", i),
                     'M',
                     static_cast<int>(parts.size()) - 1,
                     {0, 0, 0.16 * share},
                     false});
  }
  const int chest = static_cast<int>(parts.size());
  parts.push_back({"Chest", 'M', chest - 1, {0, 0, 0.16 * share}, false});
  parts.push_back({"Neck", 'M', chest, {0, 0, 0.24}, false});
  parts.push_back({"Head", 'M', chest + 1, {0, 0, 0.09}, false});
  parts.push_back({"HeadTip", 'M', chest + 2, {0, 0, 0.2}, true});
  for (const char side : {'L', 'R'}) {
    const double y = side == 'L' ? 1 : -1;
    int last = static_cast<int>(parts.size());
    parts.push_back({"UpLeg", side, 0, {0, 0.09 * y, -0.03}, false});
    parts.push_back({"Leg", side, last, {0, 0, -0.41}, false});
    parts.push_back({"Foot", side, last + 1, {0, 0, -0.40}, false});
    parts.push_back({"Toe", side, last + 2, {0.13, 0, -0.07}, false});
    last = static_cast<int>(parts.size());
    parts.push_back({"Collar", side, chest, {0, 0.03 * y, 0.18}, false});
    parts.push_back({"UpArm", side, last, {0, 0.15 * y, 0}, false});
    parts.push_back({"LoArm", side, last + 1, {0, 0, -0.28}, false});
    parts.push_back({"Hand", side, last + 2, {0, 0, -0.25}, false});
  }
  return parts;
}

std::string Name(const Part& part, const SkeletonStyle& style) {
  if (part.side == 'M') return part.name;
  if (style.side_behind) {
    return absl::StrCat(part.name, "_", std::string(1, part.side));
  }
  return absl::StrCat(part.side == 'L' ? "Left" : "Right", part.name);
}

Quaterniond About(const Vector3d& axis, double angle) {
  return motion::Exp(angle * axis);
}

// Turn of a part from standing with the arms down to the style's rest pose,
// before that pose is turned as a whole.
Quaterniond RestTurn(const Part& part, const SkeletonStyle& style) {
  const double y = part.side == 'L' ? 1 : -1;
  if (absl::EndsWith(part.name, "Arm") || part.name == "Hand") {
    return About(Vector3d::UnitX(), y * style.arms);
  }
  if (absl::EndsWith(part.name, "Leg") || part.name == "Foot" ||
      part.name == "Toe") {
    return About(Vector3d::UnitX(), y * style.legs);
  }
  return Quaterniond::Identity();
}

// Turn of a part from standing to the pose at phase `s`, in its parent.
Quaterniond Turn(const Part& part, double s, int extra_spine) {
  const double y = part.side == 'L' ? 1 : -1;
  const double bend = 0.3 * (1 - std::cos(s));
  const Vector3d across = Vector3d::UnitY();
  if (part.name == "UpLeg") return About(across, -bend);
  if (part.name == "Leg") return About(across, 2 * bend);
  if (part.name == "Foot") return About(across, -bend);
  if (part.name == "UpArm") {
    return About(across, 0.5 * y * std::sin(s)) *
           About(Vector3d::UnitX(), y * 0.25);
  }
  if (part.name == "LoArm") return About(across, -0.4 - 0.3 * std::sin(s));
  if (absl::StartsWith(part.name, "Extra") || part.name == "Chest") {
    return About(Vector3d::UnitZ(), 0.3 * std::sin(s) / (extra_spine + 1));
  }
  return Quaterniond::Identity();
}

}  // namespace

SourceClip MadeClip(const SkeletonStyle& style) {
  const std::vector<Part> parts = Parts(style.extra_spine);
  Quaterniond whole = motion::YawRotation(style.heading);
  if (style.lies) {
    whole = whole * About(Vector3d::UnitY(), -std::numbers::pi / 2);
  }
  SourceClip clip;
  clip.name = "made";
  std::vector<Quaterniond> rest;  // of each part, world
  for (const Part& part : parts) {
    rest.push_back(whole * RestTurn(part, style));
    const Vector3d offset =
        part.parent < 0
            ? Vector3d::Zero()
            : Vector3d(rest[part.parent] * part.offset / style.metres_per_unit);
    clip.skeleton.joints.push_back(
        {Name(part, style), part.parent, offset, part.is_end});
  }
  const int frames = static_cast<int>(kRate * kSeconds) + 1;
  for (int t = 0; t < frames; ++t) {
    const double s = 2 * std::numbers::pi * t / (frames - 1);
    std::vector<Quaterniond> turned, rotation;
    for (size_t i = 0; i < parts.size(); ++i) {
      const int parent = parts[i].parent;
      const Quaterniond turn = Turn(parts[i], s, style.extra_spine);
      turned.push_back(parent < 0 ? turn : turned[parent] * turn);
      const Quaterniond world = turned[i] * rest[i].conjugate();
      rotation.push_back(
          parent < 0 ? world
                     : (turned[parent] * rest[parent].conjugate()).conjugate() *
                           world);
    }
    const double bend = 0.3 * (1 - std::cos(s));
    const double height = 0.10 + 0.81 * std::cos(bend);
    clip.poses.push_back(
        {t / kRate, Vector3d(0, 0, height) / style.metres_per_unit, rotation});
  }
  return clip;
}

}  // namespace sinew::import::testing
