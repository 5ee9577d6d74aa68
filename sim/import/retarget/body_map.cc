#include "sim/import/retarget/body_map.h"

#include <algorithm>
#include <map>

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/status_macros.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

// Limb directions that differ by less are proportions, not another rest pose.
constexpr double kLeastRestAngle = 0.2;

// What characters call the joints of a source skeleton.
const std::map<std::string, std::vector<std::string>>& Aliases() {
  static const auto& aliases = *new std::map<std::string,
                                             std::vector<std::string>>{
      {"chest", {"chest", "abdomen", "waist", "spine", "torso"}},
      {"neck", {"neck", "head"}},
  };
  return aliases;
}

std::vector<std::string> NamesFor(const std::string& source) {
  const auto found = Aliases().find(source);
  return found == Aliases().end() ? std::vector<std::string>{source}
                                  : found->second;
}

bool Means(const std::string& semantic, const std::string& name) {
  return semantic == name || absl::StartsWith(semantic, name + "_");
}

// Whether `a` is `b` or lies above it.
bool IsAncestor(const mjModel& model, int a, int b) {
  while (b > a) b = model.body_parentid[b];
  return a == b;
}

// The lowest body that a hinge of this meaning moves; 0: none.
int FindBody(const mjModel& model, const std::string& source,
             const std::vector<SemanticJoint>& semantics) {
  for (const std::string& name : NamesFor(source)) {
    int body = 0;
    for (const SemanticJoint& joint : semantics) {
      if (Means(joint.semantic, name)) {
        body = std::max(body, model.jnt_bodyid[joint.joint]);
      }
    }
    if (body > 0) return body;
  }
  return 0;
}

// World poses of bodies in the zero pose, root at the origin.
struct ZeroPose {
  std::vector<Vector3d> position;
  std::vector<Quaterniond> rotation;

  ZeroPose(const mjModel& model, int root)
      : position(model.nbody, Vector3d::Zero()),
        rotation(model.nbody, Quaterniond::Identity()) {
    for (int b = root + 1; b < model.nbody; ++b) {
      const int parent = model.body_parentid[b];
      position[b] =
          position[parent] + rotation[parent] * Eigen::Map<const Vector3d>(
                                                    model.body_pos + 3 * b);
      rotation[b] =
          rotation[parent] * motion::FromWxyz(model.body_quat + 4 * b);
    }
  }
};

absl::Status CheckRequired(const BodyMap& map) {
  for (const char* side : {"left_", "right_"}) {
    for (const char* joint : {"hip", "knee", "ankle"}) {
      const std::string name = absl::StrCat(side, joint);
      if (std::find(map.unmapped.begin(), map.unmapped.end(), name) !=
          map.unmapped.end()) {
        return absl::InvalidArgumentError(absl::StrCat(
            "character: expected hinges whose semantic is ", name, " or ",
            name, "_*, found none"));
      }
    }
  }
  return absl::OkStatus();
}

// The single mapped body below index `i`, or -1.
int OnlyChild(const BodyMap& map, int i) {
  int child = -1;
  for (int j = 0; j < static_cast<int>(map.bodies.size()); ++j) {
    if (map.bodies[j].parent != i) continue;
    if (child >= 0) return -1;
    child = j;
  }
  return child;
}

// For each mapped body the turn from the model's zero pose to the source's
// rest pose: limbs (bodies with one child) point along the source's, others
// follow their parent.
void Align(const SourceSkeleton& skeleton, const ZeroPose& zero,
           BodyMap* map) {
  std::vector<Quaterniond> turn(map->bodies.size(), Quaterniond::Identity());
  for (int i = 0; i < static_cast<int>(map->bodies.size()); ++i) {
    MappedBody& body = map->bodies[i];
    if (body.parent >= 0) turn[i] = turn[body.parent];
    const int child = OnlyChild(*map, i);
    if (child >= 0 && body.parent >= 0) {
      const Vector3d model_limb =
          turn[i] * (zero.position[map->bodies[child].body] -
                     zero.position[body.body]);
      const Quaterniond more = Quaterniond::FromTwoVectors(
          model_limb, skeleton.joints[map->bodies[child].source].offset);
      if (motion::Log(more).norm() > kLeastRestAngle) turn[i] = more * turn[i];
    }
    body.alignment = turn[i] * zero.rotation[body.body];
  }
}

int Index(const BodyMap& map, const SourceSkeleton& skeleton,
          const std::string& name) {
  const int source = skeleton.Find(name);
  for (int i = 0; i < static_cast<int>(map.bodies.size()); ++i) {
    if (map.bodies[i].source == source) return i;
  }
  return -1;
}

// Leg lengths and hip centres. Precondition: CheckRequired passed.
void Measure(const SourceSkeleton& skeleton, const ZeroPose& zero,
             BodyMap* map) {
  double model_length = 0;
  double source_length = 0;
  map->source_hips.setZero();
  map->model_hips.setZero();
  for (const std::string side : {"left_", "right_"}) {
    const MappedBody& hip = map->bodies[Index(*map, skeleton, side + "hip")];
    const MappedBody& knee = map->bodies[Index(*map, skeleton, side + "knee")];
    const MappedBody& ankle =
        map->bodies[Index(*map, skeleton, side + "ankle")];
    model_length +=
        (zero.position[knee.body] - zero.position[hip.body]).norm() +
        (zero.position[ankle.body] - zero.position[knee.body]).norm();
    source_length += skeleton.joints[knee.source].offset.norm() +
                     skeleton.joints[ankle.source].offset.norm();
    map->source_hips += skeleton.joints[hip.source].offset / 2;
    map->model_hips += zero.position[hip.body] / 2;
  }
  map->scale = model_length / source_length;
}

// Adds the body that plays source joint `source`, if the model has one.
void AddBody(const SourceSkeleton& skeleton, const mjModel& model, int root,
             const std::vector<SemanticJoint>& semantics, int source,
             BodyMap* map) {
  const SourceJoint& joint = skeleton.joints[source];
  const int body =
      joint.parent < 0 ? root : FindBody(model, joint.name, semantics);
  int parent = -1;
  for (int i = 0; i < static_cast<int>(map->bodies.size()); ++i) {
    if (IsAncestor(model, map->bodies[i].body, body)) parent = i;
  }
  const bool is_new =
      body > 0 && (joint.parent < 0 ||
                   (parent >= 0 && map->bodies[parent].body != body));
  if (!is_new) {
    map->unmapped.push_back(joint.name);
    return;
  }
  HingeChain chain;
  if (parent >= 0) {
    chain = MakeHingeChain(model, map->bodies[parent].body, body);
  }
  map->bodies.push_back(
      {source, body, parent, chain, Quaterniond::Identity()});
}

}  // namespace

absl::StatusOr<BodyMap> MakeBodyMap(
    const SourceSkeleton& skeleton, const mjModel& model,
    const std::vector<SemanticJoint>& semantics) {
  if (model.njnt == 0 || model.jnt_type[0] != mjJNT_FREE) {
    return absl::InvalidArgumentError(
        "character: expected a free joint on its first body, found none");
  }
  const int root = model.jnt_bodyid[0];
  BodyMap map;
  for (int i = 0; i < static_cast<int>(skeleton.joints.size()); ++i) {
    AddBody(skeleton, model, root, semantics, i, &map);
  }
  SINEW_RETURN_IF_ERROR(CheckRequired(map));
  const ZeroPose zero(model, root);
  Align(skeleton, zero, &map);
  Measure(skeleton, zero, &map);
  return map;
}

}  // namespace sinew::import
