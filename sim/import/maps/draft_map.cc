#include "sim/import/maps/draft_map.h"

#include <algorithm>
#include <array>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "sim/import/maps/skeleton_maps.h"

namespace sinew::import {
namespace {

// Bones shorter than this share of the limb's longest are no thigh or shin.
constexpr double kLeastBoneShare = 0.4;

enum Side { kMiddle = 0, kLeft = 1, kRight = 2 };
enum Limb { kNone = 0, kLeg = 1, kArm = 2 };

const std::vector<std::string>& LegWords() {
  static const auto& words = *new std::vector<std::string>{
      "hip",   "thigh", "femur",    "upleg",    "leg",   "shin",  "tibia",
      "knee",  "calf",  "ankle",    "foot",     "toe",   "talus", "buttock",
      "loleg", "ball",  "upperleg", "lowerleg", "lowleg"};
  return words;
}

const std::vector<std::string>& ArmWords() {
  static const auto& words = *new std::vector<std::string>{
      "clavicle", "collar",  "shoulder", "shldr",    "humerus",
      "arm",      "uparm",   "loarm",    "radius",   "ulna",
      "elbow",    "forearm", "wrist",    "hand",     "finger",
      "thumb",    "index",   "upperarm", "lowerarm", "lowarm"};
  return words;
}

// "LHipJoint2" to {"l", "hip", "joint"}: at separators, digits and changes of
// case.
std::vector<std::string> Words(absl::string_view name) {
  std::vector<std::string> words(1);
  for (size_t i = 0; i < name.size(); ++i) {
    const bool letter = absl::ascii_isalpha(name[i]);
    const bool upper = absl::ascii_isupper(name[i]);
    const bool after_lower = i > 0 && absl::ascii_islower(name[i - 1]);
    const bool before_lower =
        i + 1 < name.size() && absl::ascii_islower(name[i + 1]);
    if (!letter || (upper && (after_lower || before_lower))) {
      if (!words.back().empty()) words.emplace_back();
    }
    if (letter) words.back() += absl::ascii_tolower(name[i]);
  }
  if (words.back().empty()) words.pop_back();
  return words;
}

// Whether `word` begins with a word of the list ("toes", "handend").
bool NamesPart(absl::string_view word, const std::vector<std::string>& list) {
  return std::any_of(list.begin(), list.end(), [word](const auto& part) {
    return absl::StartsWith(word, part);
  });
}

bool NamesLimb(absl::string_view word) {
  return NamesPart(word, LegWords()) || NamesPart(word, ArmWords());
}

Side SideOf(const std::vector<std::string>& words) {
  for (const std::string& word : words) {
    if (word == "l" || word == "left") return kLeft;
    if (word == "r" || word == "right") return kRight;
    for (const auto& [prefix, side] : {std::pair{"left", kLeft},
                                       {"right", kRight},
                                       {"l", kLeft},
                                       {"r", kRight}}) {
      if (!absl::StartsWith(word, prefix)) continue;
      if (NamesLimb(word.substr(absl::string_view(prefix).size()))) {
        return side;
      }
    }
  }
  return kMiddle;
}

Limb LimbOf(const std::vector<std::string>& words) {
  for (const std::string& word : words) {
    const std::string bare = !word.empty() && (word[0] == 'l' || word[0] == 'r')
                                 ? word.substr(1)
                                 : word;
    for (const absl::string_view part :
         {absl::string_view(word), absl::string_view(bare)}) {
      if (NamesPart(part, LegWords())) return kLeg;
      if (NamesPart(part, ArmWords())) return kArm;
    }
  }
  return kNone;
}

// The draft in the making.
class Drafter {
 public:
  Drafter(const SourceSkeleton& skeleton, absl::string_view name)
      : skeleton_(skeleton), joints_(static_cast<int>(skeleton.joints.size())) {
    map_.set_name(std::string(name));
    map_.set_description("Drafted from names and lengths; please check.");
    for (const SourceJoint& joint : skeleton.joints) {
      const std::vector<std::string> words = Words(joint.name);
      Side side = SideOf(words);
      Limb limb = LimbOf(words);
      if (joint.parent >= 0 && side_[joint.parent] != kMiddle) {
        side = side_[joint.parent];
        // A hand's end is a hand's, whatever it is called.
        if (limb_[joint.parent] != kNone) limb = limb_[joint.parent];
      }
      side_.push_back(side);
      limb_.push_back(side == kMiddle ? kNone : limb);
    }
  }

  v1::SkeletonMap Draft() {
    int meeting = -1;
    std::array<std::vector<int>, 2> arms;
    for (const Side side : {kLeft, kRight}) {
      const std::string prefix = side == kLeft ? "left_" : "right_";
      AddLeg(prefix, LongestPath(side, kLeg));
      arms[side - 1] = LongestPath(side, kArm);
      AddArm(prefix, arms[side - 1]);
    }
    if (!arms[0].empty() && !arms[1].empty()) {
      meeting = CommonAncestor(arms[0][0], arms[1][0]);
    }
    AddTrunk(meeting);
    return std::move(map_);
  }

 private:
  double Length(int joint) const {
    return skeleton_.joints[joint].offset.norm();
  }
  int Parent(int joint) const { return skeleton_.joints[joint].parent; }
  bool IsEnd(int joint) const { return skeleton_.joints[joint].is_end; }

  void Add(const std::string& role, int joint) {
    v1::JointRole* added = map_.add_joints();
    added->set_source(skeleton_.joints[joint].name);
    added->set_role(role);
  }

  // Joints of one limb from the trunk to the tip that lies furthest along.
  std::vector<int> LongestPath(Side side, Limb limb) const {
    int tip = -1;
    double longest = -1;
    std::vector<double> reach(joints_, 0);
    for (int i = 0; i < joints_; ++i) {
      if (side_[i] != side || limb_[i] != limb) continue;
      const int parent = Parent(i);
      const bool inside = parent >= 0 && side_[parent] == side;
      reach[i] = inside ? reach[parent] + Length(i) : 0;
      if (reach[i] > longest) {
        longest = reach[i];
        tip = i;
      }
    }
    std::vector<int> path;
    for (int i = tip; i >= 0 && side_[i] == side; i = Parent(i)) {
      path.push_back(i);
    }
    std::reverse(path.begin(), path.end());
    return path;
  }

  // Index in the path of the joint between the two longest bones that follow
  // one another; -1: none.
  int Middle(const std::vector<int>& path) const {
    int best = -1;
    double longest = 0, sum = 0;
    for (size_t i = 1; i < path.size(); ++i) {
      longest = std::max(longest, Length(path[i]));
    }
    for (size_t i = 1; i + 1 < path.size(); ++i) {
      const double upper = Length(path[i]), lower = Length(path[i + 1]);
      if (std::min(upper, lower) < kLeastBoneShare * longest) continue;
      if (upper + lower <= sum) continue;
      sum = upper + lower;
      best = static_cast<int>(i);
    }
    return best;
  }

  void AddLeg(const std::string& prefix, const std::vector<int>& path) {
    const int middle = Middle(path);
    if (middle < 0) return;
    Add(absl::StrCat(prefix, "hip"), path[middle - 1]);
    Add(absl::StrCat(prefix, "knee"), path[middle]);
    Add(absl::StrCat(prefix, "ankle"), path[middle + 1]);
    for (size_t i = middle + 2; i < path.size(); ++i) {
      if (Length(path[i]) == 0 || IsEnd(path[i])) continue;
      Add(absl::StrCat(prefix, "toe"), path[i]);
      return;
    }
  }

  void AddArm(const std::string& prefix, const std::vector<int>& path) {
    const int middle = Middle(path);
    if (middle < 0) return;
    if (middle >= 2) Add(absl::StrCat(prefix, "clavicle"), path[middle - 2]);
    Add(absl::StrCat(prefix, "shoulder"), path[middle - 1]);
    Add(absl::StrCat(prefix, "elbow"), path[middle]);
    if (!IsEnd(path[middle + 1])) {
      Add(absl::StrCat(prefix, "wrist"), path[middle + 1]);
    }
  }

  int CommonAncestor(int a, int b) const {
    while (a != b) (a > b ? a : b) = Parent(a > b ? a : b);
    return a;
  }

  // The trunk's path below `chest` to the head or, without one of that name,
  // to the joint furthest along.
  std::vector<int> HeadPath(int chest) const {
    int tip = -1;
    bool named = false;
    double longest = -1;
    std::vector<double> reach(joints_, 0);
    for (int i = chest + 1; i < joints_; ++i) {
      int ancestor = i;
      while (ancestor > chest) ancestor = Parent(ancestor);
      if (ancestor != chest || side_[i] != kMiddle || IsEnd(i)) continue;
      reach[i] = reach[Parent(i)] + Length(i);
      const std::vector<std::string> words = Words(skeleton_.joints[i].name);
      const bool is_head =
          std::find(words.begin(), words.end(), "head") != words.end();
      if (named ? false : (is_head || reach[i] > longest)) {
        named = is_head;
        longest = reach[i];
        tip = i;
      }
    }
    std::vector<int> path;
    for (int i = tip; i > chest; i = Parent(i)) path.push_back(i);
    std::reverse(path.begin(), path.end());
    return path;
  }

  void AddTrunk(int chest) {
    const int root = Root();
    Add("root", root);
    if (chest < 0) return;
    if (chest != root) {
      std::vector<int> spine;
      for (int i = Parent(chest); i >= 0 && i != root; i = Parent(i)) {
        spine.push_back(i);
      }
      if (!spine.empty()) Add("spine", spine.back());
      Add("chest", chest);
    }
    const std::vector<int> path = HeadPath(chest);
    if (path.size() > 1) Add("neck", path.front());
    if (!path.empty()) Add("head", path.back());
  }

  // The joint that carries both legs.
  int Root() const {
    const std::vector<int> left = LongestPath(kLeft, kLeg);
    const std::vector<int> right = LongestPath(kRight, kLeg);
    if (left.empty() || right.empty()) return 0;
    return CommonAncestor(left[0], right[0]);
  }

  const SourceSkeleton& skeleton_;
  const int joints_;
  std::vector<Side> side_;  // [joints]
  std::vector<Limb> limb_;
  v1::SkeletonMap map_;
};

}  // namespace

absl::StatusOr<v1::SkeletonMap> DraftSkeletonMap(const SourceSkeleton& skeleton,
                                                 absl::string_view name) {
  v1::SkeletonMap map = Drafter(skeleton, name).Draft();
  std::vector<std::string> missing;
  for (const std::string& role : RequiredRoles()) {
    const bool found = std::any_of(
        map.joints().begin(), map.joints().end(),
        [&role](const auto& joint) { return joint.role() == role; });
    if (!found) missing.push_back(role);
  }
  if (missing.empty()) return map;
  std::vector<std::string> names;
  for (const SourceJoint& joint : skeleton.joints) {
    names.push_back(joint.name);
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "no skeleton map fits: expected joints named like left and right hip, "
      "knee and ankle, found none for ",
      absl::StrJoin(missing, ", "), " among ", absl::StrJoin(names, ", ")));
}

std::string SkeletonMapText(const v1::SkeletonMap& map) {
  std::string text = absl::StrCat(
      "# proto-file: proto/sinew/v1/skeleton_map.proto\n"
      "# proto-message: sinew.v1.SkeletonMap\nname: \"",
      map.name(), "\"\ndescription: \"", absl::CEscape(map.description()),
      "\"\n");
  if (map.first_frame_is_rest()) {
    absl::StrAppend(&text, "first_frame_is_rest: true\n");
  }
  for (const v1::JointRole& joint : map.joints()) {
    absl::StrAppend(&text, "joints { source: \"", absl::CEscape(joint.source()),
                    "\" role: \"", joint.role(), "\"");
    for (const double angle : joint.rest_degrees()) {
      absl::StrAppend(&text, " rest_degrees: ", angle);
    }
    absl::StrAppend(&text, " }\n");
  }
  return text;
}

}  // namespace sinew::import
