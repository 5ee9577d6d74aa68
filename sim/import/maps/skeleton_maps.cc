#include "sim/import/maps/skeleton_maps.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <numeric>
#include <set>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/config/text_proto.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "common/workspace_files.h"

namespace sinew::import {
namespace {

constexpr char kFolder[] = "sim/import/maps/skeletons";
constexpr char kExtension[] = ".textproto";
// Larger files are no maps.
constexpr int64_t kMaxBytes = int64_t{1} << 20;
// Near misses that an error lists.
constexpr size_t kSuggestions = 3;

std::vector<std::string> MakeRoles() {
  std::vector<std::string> roles = {"root", "spine", "chest",
                                    "neck", "head",  "head_end"};
  for (const char* side : {"left_", "right_"}) {
    for (const char* role :
         {"hip", "knee", "ankle", "toe", "toe_end", "clavicle", "shoulder",
          "elbow", "wrist", "hand_end"}) {
      roles.push_back(absl::StrCat(side, role));
    }
  }
  return roles;
}

bool Contains(const std::vector<std::string>& list, absl::string_view item) {
  return std::find(list.begin(), list.end(), item) != list.end();
}

absl::Status CheckName(const v1::SkeletonMap& map, absl::string_view source) {
  const bool good =
      !map.name().empty() &&
      std::all_of(map.name().begin(), map.name().end(), [](char c) {
        return absl::ascii_islower(c) || absl::ascii_isdigit(c) || c == '_';
      });
  if (good) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      source, ": name: expected [a-z0-9_]+, found \"", map.name(), "\""));
}

absl::Status CheckJoint(const v1::JointRole& joint, absl::string_view source) {
  if (!Contains(AllRoles(), joint.role())) {
    return absl::InvalidArgumentError(absl::StrCat(
        source, ": joint \"", joint.source(), "\": expected a role (",
        absl::StrJoin(AllRoles(), ", "), "), found \"", joint.role(), "\""));
  }
  const int count = joint.rest_degrees_size();
  const bool finite =
      std::all_of(joint.rest_degrees().begin(), joint.rest_degrees().end(),
                  [](double angle) { return std::isfinite(angle); });
  if ((count != 0 && count != 3) || !finite) {
    return absl::InvalidArgumentError(absl::StrCat(
        source, ": joint \"", joint.source(),
        "\": rest_degrees: expected three finite numbers or none, found ",
        absl::StrJoin(joint.rest_degrees(), ", ")));
  }
  return absl::OkStatus();
}

absl::Status CheckMap(const v1::SkeletonMap& map, absl::string_view source) {
  SINEW_RETURN_IF_ERROR(CheckName(map, source));
  std::set<std::string> roles, joints;
  for (const v1::JointRole& joint : map.joints()) {
    SINEW_RETURN_IF_ERROR(CheckJoint(joint, source));
    if (!roles.insert(joint.role()).second) {
      return absl::InvalidArgumentError(
          absl::StrCat(source, ": expected each role once, found \"",
                       joint.role(), "\" twice"));
    }
    if (!joints.insert(joint.source()).second) {
      return absl::InvalidArgumentError(
          absl::StrCat(source, ": expected each joint once, found \"",
                       joint.source(), "\" twice"));
    }
  }
  std::vector<std::string> missing;
  for (const std::string& role : RequiredRoles()) {
    if (!roles.contains(role)) missing.push_back(role);
  }
  if (missing.empty()) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      source, ": expected joints for ", absl::StrJoin(RequiredRoles(), ", "),
      ", found none for ", absl::StrJoin(missing, ", ")));
}

// Part of a name after its name space.
absl::string_view Bare(absl::string_view name) {
  const size_t colon = name.rfind(':');
  if (colon != absl::string_view::npos) name.remove_prefix(colon + 1);
  constexpr absl::string_view kMixamo = "mixamorig";
  if (absl::StartsWith(name, kMixamo) && name.size() > kMixamo.size()) {
    name.remove_prefix(kMixamo.size());
  }
  return name;
}

// Edit distance, letters in either case alike.
int Distance(absl::string_view a, absl::string_view b) {
  std::vector<int> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (size_t i = 1; i <= a.size(); ++i) {
    int diagonal = row[0];
    row[0] = static_cast<int>(i);
    for (size_t j = 1; j <= b.size(); ++j) {
      const bool same =
          absl::ascii_tolower(a[i - 1]) == absl::ascii_tolower(b[j - 1]);
      const int replaced = diagonal + (same ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row[b.size()];
}

std::vector<std::string> Nearest(const SourceSkeleton& skeleton,
                                 absl::string_view name) {
  std::vector<std::pair<int, std::string>> ranked;
  for (const SourceJoint& joint : skeleton.joints) {
    ranked.emplace_back(Distance(Bare(joint.name), Bare(name)), joint.name);
  }
  std::sort(ranked.begin(), ranked.end());
  std::vector<std::string> names;
  for (size_t i = 0; i < std::min(kSuggestions, ranked.size()); ++i) {
    names.push_back(ranked[i].second);
  }
  return names;
}

bool IsBelow(const SourceSkeleton& skeleton, int joint, int ancestor) {
  while (joint > ancestor) joint = skeleton.joints[joint].parent;
  return joint == ancestor;
}

// Limbs must hang together.
absl::Status CheckLimbs(const v1::SkeletonMap& map,
                        const SourceSkeleton& skeleton) {
  std::map<std::string, std::string> names;
  for (const v1::JointRole& joint : map.joints()) {
    names[joint.role()] = joint.source();
  }
  for (const char* side : {"left_", "right_"}) {
    for (const auto& [above, below] : {std::pair{"hip", "knee"},
                                       {"knee", "ankle"},
                                       {"ankle", "toe"},
                                       {"shoulder", "elbow"},
                                       {"elbow", "wrist"}}) {
      const auto a = names.find(absl::StrCat(side, above));
      const auto b = names.find(absl::StrCat(side, below));
      if (a == names.end() || b == names.end()) continue;
      if (IsBelow(skeleton, FindMapped(skeleton, b->second),
                  FindMapped(skeleton, a->second))) {
        continue;
      }
      return absl::InvalidArgumentError(
          absl::StrCat("map ", map.name(), ": expected joint \"", b->second,
                       "\" (", b->first, ") below \"", a->second, "\" (",
                       a->first, "), found it elsewhere in the skeleton"));
    }
  }
  return absl::OkStatus();
}

}  // namespace

const std::vector<std::string>& AllRoles() {
  static const auto& roles = *new std::vector<std::string>(MakeRoles());
  return roles;
}

const std::vector<std::string>& RequiredRoles() {
  static const auto& roles = *new std::vector<std::string>{
      "root",      "left_hip",   "left_knee",  "left_ankle",
      "right_hip", "right_knee", "right_ankle"};
  return roles;
}

absl::StatusOr<v1::SkeletonMap> ParseSkeletonMap(absl::string_view text,
                                                 absl::string_view source) {
  v1::SkeletonMap map;
  SINEW_RETURN_IF_ERROR(ParseTextProto(text, source, map));
  SINEW_RETURN_IF_ERROR(CheckMap(map, source));
  return map;
}

absl::StatusOr<v1::SkeletonMap> LoadSkeletonMap(
    const std::string& name_or_path) {
  std::string path = name_or_path;
  if (!absl::StrContains(path, "/") && !absl::StrContains(path, ".")) {
    SINEW_ASSIGN_OR_RETURN(
        path, FindWorkspaceFile(
                  JoinPath(kFolder, absl::StrCat(name_or_path, kExtension))));
  }
  SINEW_ASSIGN_OR_RETURN(const std::string text, ReadFile(path, kMaxBytes));
  return ParseSkeletonMap(text, path);
}

absl::StatusOr<std::vector<v1::SkeletonMap>> KnownSkeletonMaps() {
  SINEW_ASSIGN_OR_RETURN(
      const std::string any,
      FindWorkspaceFile(JoinPath(kFolder, "deepmimic.textproto")));
  const std::string folder = std::filesystem::path(any).parent_path().string();
  SINEW_ASSIGN_OR_RETURN(std::vector<std::string> names, ListDirectory(folder));
  std::sort(names.begin(), names.end());
  std::vector<v1::SkeletonMap> maps;
  for (const std::string& name : names) {
    if (!absl::EndsWith(name, kExtension)) continue;
    SINEW_ASSIGN_OR_RETURN(maps.emplace_back(),
                           LoadSkeletonMap(JoinPath(folder, name)));
  }
  return maps;
}

int FindMapped(const SourceSkeleton& skeleton, absl::string_view name) {
  const int exact = skeleton.Find(std::string(name));
  if (exact >= 0) return exact;
  for (size_t i = 0; i < skeleton.joints.size(); ++i) {
    if (Bare(skeleton.joints[i].name) == Bare(name)) {
      return static_cast<int>(i);
    }
  }
  return -1;
}

absl::Status CheckMapFits(const v1::SkeletonMap& map,
                          const SourceSkeleton& skeleton) {
  SINEW_RETURN_IF_ERROR(CheckMap(map, absl::StrCat("map ", map.name())));
  for (const v1::JointRole& joint : map.joints()) {
    if (FindMapped(skeleton, joint.source()) >= 0) continue;
    return absl::InvalidArgumentError(absl::StrCat(
        "map ", map.name(), ": expected a joint \"", joint.source(), "\" (",
        joint.role(), "), found none in the skeleton; nearest: ",
        absl::StrJoin(Nearest(skeleton, joint.source()), ", ")));
  }
  return CheckLimbs(map, skeleton);
}

const v1::SkeletonMap* FindMapFor(const std::vector<v1::SkeletonMap>& maps,
                                  const SourceSkeleton& skeleton) {
  const v1::SkeletonMap* best = nullptr;
  for (const v1::SkeletonMap& map : maps) {
    if (best != nullptr && map.joints_size() <= best->joints_size()) continue;
    if (CheckMapFits(map, skeleton).ok()) best = &map;
  }
  return best;
}

}  // namespace sinew::import
