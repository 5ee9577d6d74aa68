#include "sim/import/retarget/body_map.h"

#include <algorithm>
#include <map>

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/status_macros.h"
#include "sim/import/retarget/foot_pose.h"
#include "sim/import/retarget/zero_pose.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

// What characters call the hinges that a role moves, likeliest first.
std::vector<std::string> NamesFor(const std::string& role) {
  static const auto& aliases =
      *new std::map<std::string, std::vector<std::string>>{
          {"spine", {"spine", "lowerback", "abdomen", "waist"}},
          {"chest",
           {"chest", "thorax", "upperback", "torso", "abdomen", "waist",
            "spine", "lowerback"}},
          {"neck", {"neck", "lowerneck", "head"}},
          {"head", {"head", "upperneck", "neck"}},
          {"left_wrist", {"left_wrist", "left_hand"}},
          {"right_wrist", {"right_wrist", "right_hand"}},
          {"left_toe", {"left_toe", "left_toes"}},
          {"right_toe", {"right_toe", "right_toes"}},
      };
  const auto found = aliases.find(role);
  return found == aliases.end() ? std::vector<std::string>{role}
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
int FindBody(const ImportModel& model, const std::string& role) {
  for (const std::string& name : NamesFor(role)) {
    int body = 0;
    for (const SemanticJoint& joint : model.semantics) {
      if (Means(joint.semantic, name)) {
        body = std::max(body, model.model->jnt_bodyid[joint.joint]);
      }
    }
    if (body > 0) return body;
  }
  return 0;
}

// The map in the making.
class Mapper {
 public:
  Mapper(const RoleTrack& track, const ImportModel& model)
      : track_(track),
        model_(model),
        root_(model.model->jnt_bodyid[0]),
        zero_(*model.model, root_) {}

  absl::StatusOr<BodyMap> Map() {
    for (size_t role = 0; role < track_.roles.size(); ++role) {
      if (track_.turns[role]) AddBody(static_cast<int>(role));
    }
    SINEW_RETURN_IF_ERROR(CheckRequired());
    for (size_t i = 0; i < map_.bodies.size(); ++i) {
      AddPoint(map_.bodies[i].role, static_cast<int>(i),
               Centre(map_.bodies[i]));
    }
    for (const std::string side : {"left_", "right_"}) {
      AddWrist(side);
      AddToe(side);
    }
    Align();
    Measure();
    return std::move(map_);
  }

 private:
  const std::string& role(const MappedBody& body) const {
    return track_.roles[body.role];
  }

  int FindMappedRole(const std::string& name) const {
    for (size_t i = 0; i < map_.bodies.size(); ++i) {
      if (role(map_.bodies[i]) == name) return static_cast<int>(i);
    }
    return -1;
  }

  // Adds the body that plays a role, if the model has one.
  void AddBody(int role) {
    const mjModel& m = *model_.model;
    const bool is_root = role == 0;
    const int body = is_root ? root_ : FindBody(model_, track_.roles[role]);
    if (body == 0) {
      map_.unmapped.push_back(track_.roles[role]);
      return;
    }
    int parent = -1;
    for (int i = 0; i < static_cast<int>(map_.bodies.size()); ++i) {
      if (map_.bodies[i].body == body) {
        map_.bodies[i].role = role;  // nearer to the limbs
        return;
      }
      if (IsAncestor(m, map_.bodies[i].body, body)) parent = i;
    }
    HingeChain chain;
    if (!is_root) chain = MakeHingeChain(m, map_.bodies[parent].body, body);
    map_.bodies.push_back({role, body, parent, chain, Quaterniond::Identity()});
  }

  absl::Status CheckRequired() {
    for (const char* side : {"left_", "right_"}) {
      for (const char* joint : {"hip", "knee", "ankle"}) {
        const std::string name = absl::StrCat(side, joint);
        if (FindMappedRole(name) >= 0) continue;
        const int role = track_.Find(name);
        if (role >= 0 && !track_.turns[role]) {
          return absl::InvalidArgumentError(absl::StrCat(
              "skeleton: expected a ", name,
              " that turns, with a joint or an end below it, found an end"));
        }
        return absl::InvalidArgumentError(
            absl::StrCat("character: expected hinges whose semantic is ", name,
                         " or ", name, "_*, found none"));
      }
    }
    const auto is_small = [](const std::string& name) {
      return !absl::EndsWith(name, "shoulder") &&
             !absl::EndsWith(name, "elbow") && name != "chest";
    };
    std::erase_if(map_.unmapped, is_small);
    return absl::OkStatus();
  }

  // Zero pose, world.
  Vector3d Centre(const MappedBody& body) const {
    return body.chain.joints.empty()
               ? zero_.position[body.body]
               : zero_.Centre(*model_.model, body.chain.joints);
  }

  void AddPoint(int role, int mapped, const Vector3d& zero_place) {
    const int body = map_.bodies[mapped].body;
    map_.points.push_back({role, mapped,
                           zero_.rotation[body].conjugate() *
                               (zero_place - zero_.position[body])});
  }

  // Where hands are fixed to forearms.
  void AddWrist(const std::string& side) {
    const int role = track_.Find(side + "wrist");
    const int elbow = FindMappedRole(side + "elbow");
    if (role < 0 || elbow < 0 || map_.FindPoint(role) >= 0) return;
    const mjModel& m = *model_.model;
    const int forearm = map_.bodies[elbow].body;
    for (int b = forearm + 1; b < m.nbody; ++b) {
      if (m.body_parentid[b] != forearm || m.body_jntnum[b] > 0) continue;
      AddPoint(role, elbow, zero_.position[b]);
      return;
    }
  }

  // The front of the sole where feet have no toes.
  void AddToe(const std::string& side) {
    const int role = track_.Find(side + "toe");
    const int ankle = FindMappedRole(side + "ankle");
    if (role < 0 || map_.FindPoint(role) >= 0) return;
    Vector3d front(-1e9, 0, 0);
    for (const GroundPoint& point : model_.points) {
      if (point.body != map_.bodies[ankle].body) continue;
      Vector3d place = zero_.position[point.body] +
                       zero_.rotation[point.body] * point.position;
      place.x() += point.radius;
      place.z() -= point.radius;
      if (place.x() > front.x()) front = place;
    }
    if (front.x() < -1e8) return;
    front.y() = Centre(map_.bodies[ankle]).y();
    AddPoint(role, ankle, front);
  }

  // For each mapped body the turn from the model's zero pose to the standing
  // pose of the source.
  void Align() {
    std::vector<Quaterniond> turn(map_.bodies.size(), Quaterniond::Identity());
    for (int i = 0; i < static_cast<int>(map_.bodies.size()); ++i) {
      MappedBody& body = map_.bodies[i];
      const std::string& name = role(body);
      if (!LimbParent(name).empty()) turn[i] = turn[body.parent];
      if (absl::EndsWith(name, "_ankle")) {
        turn[i] = FootPose(track_, name.substr(0, name.find('_') + 1));
      }
      for (const RolePoint& end : map_.points) {
        if (LimbParent(track_.roles[end.role]) != name) continue;
        const Vector3d limb = turn[i] * (ZeroPlace(end) - Centre(body));
        const Vector3d wanted =
            track_.standing[end.role] - track_.standing[body.role];
        constexpr double kLeastLimb = 1e-6;  // m; a shorter one points nowhere
        if (limb.norm() < kLeastLimb || wanted.norm() < kLeastLimb) continue;
        turn[i] = Quaterniond::FromTwoVectors(limb, wanted) * turn[i];
      }
      body.alignment = turn[i] * zero_.rotation[body.body];
    }
  }

  Vector3d ZeroPlace(const RolePoint& point) const {
    const int body = map_.bodies[point.mapped].body;
    return zero_.position[body] + zero_.rotation[body] * point.position;
  }

  // Leg lengths and hip centres.
  void Measure() {
    double model_length = 0;
    double source_length = 0;
    map_.model_hips.setZero();
    for (const std::string side : {"left_", "right_"}) {
      Vector3d last = Vector3d::Zero(), last_source = Vector3d::Zero();
      for (const char* joint : {"hip", "knee", "ankle"}) {
        const MappedBody& body = map_.bodies[FindMappedRole(side + joint)];
        const Vector3d place = Centre(body);
        const Vector3d& source = track_.standing[body.role];
        if (LimbParent(role(body)).empty()) {
          map_.model_hips += place / 2;
        } else {
          model_length += (place - last).norm();
          source_length += (source - last_source).norm();
        }
        last = place;
        last_source = source;
      }
    }
    map_.scale = model_length / source_length;
  }

  const RoleTrack& track_;
  const ImportModel& model_;
  const int root_;
  const ZeroPose zero_;
  BodyMap map_;
};

}  // namespace

std::string LimbParent(const std::string& role) {
  for (const auto& [child, parent] : {std::pair{"_knee", "_hip"},
                                      {"_ankle", "_knee"},
                                      {"_elbow", "_shoulder"},
                                      {"_wrist", "_elbow"}}) {
    if (!absl::EndsWith(role, child)) continue;
    return role.substr(0, role.find('_')) + parent;
  }
  return "";
}

int BodyMap::FindPoint(int role) const {
  for (size_t i = 0; i < points.size(); ++i) {
    if (points[i].role == role) return static_cast<int>(i);
  }
  return -1;
}

absl::StatusOr<BodyMap> MakeBodyMap(const RoleTrack& track,
                                    const ImportModel& model) {
  return Mapper(track, model).Map();
}

}  // namespace sinew::import
