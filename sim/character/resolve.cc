#include "sim/character/resolve.h"

#include <algorithm>
#include <limits>
#include <set>

#include "absl/strings/str_cat.h"
#include "common/status_macros.h"

namespace sinew::character {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string Quoted(const std::string& name) {
  return absl::StrCat("\"", name, "\"");
}

bool Contains(const std::vector<int>& values, int value) {
  return std::find(values.begin(), values.end(), value) != values.end();
}

bool TouchesThings(const mjModel& model, int geom) {
  return model.geom_contype[geom] != 0 || model.geom_conaffinity[geom] != 0;
}

}  // namespace

absl::Status Resolver::Bad(absl::string_view field, absl::string_view expected,
                           absl::string_view found) const {
  return absl::InvalidArgumentError(absl::StrCat(
      source_, ": ", field, ": expected ", expected, ", found ", found));
}

absl::StatusOr<int> Resolver::Body(absl::string_view field,
                                   const std::string& name) const {
  const int id = mj_name2id(&model_, mjOBJ_BODY, name.c_str());
  if (id <= 0) return Bad(field, "a body of the model", Quoted(name));
  return id;
}

absl::Status Resolver::CheckTree() const {
  for (int body = 1; body < model_.nbody; ++body) {
    if (model_.body_rootid[body] != 1 || model_.body_mocapid[body] >= 0) {
      return Bad(
          "model", "one tree of bodies below the world, none of mocap",
          absl::StrCat("body ", Quoted(mj_id2name(&model_, mjOBJ_BODY, body)),
                       " outside it"));
    }
  }
  const int num_free = static_cast<int>(
      std::count(model_.jnt_type, model_.jnt_type + model_.njnt, mjJNT_FREE));
  if (num_free != 1 || model_.jnt_type[0] != mjJNT_FREE ||
      model_.jnt_bodyid[0] != 1) {
    return Bad("model", "one free joint, on the first body below the world",
               absl::StrCat(num_free, " free joints"));
  }
  std::set<std::string> known;
  for (const v1::Joint& joint : character_.joints()) known.insert(joint.name());
  for (int id = 1; id < model_.njnt; ++id) {
    const char* found = mj_id2name(&model_, mjOBJ_JOINT, id);
    const std::string name = found == nullptr ? "" : found;
    if (model_.jnt_type[id] != mjJNT_HINGE) {
      return Bad("model", "hinges only below the root",
                 absl::StrCat("joint ", Quoted(name)));
    }
    if (known.count(name) == 0) {
      return Bad("joints", "every hinge of the model",
                 absl::StrCat("none for ", Quoted(name)));
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<JointInfo>> Resolver::Joints() const {
  std::vector<JointInfo> joints;
  for (const v1::Joint& joint : character_.joints()) {
    const int id = mj_name2id(&model_, mjOBJ_JOINT, joint.name().c_str());
    if (id < 0 || model_.jnt_type[id] != mjJNT_HINGE) {
      return Bad("joints", "hinges of the model", Quoted(joint.name()));
    }
    const bool limited = model_.jnt_limited[id] != 0;
    const double lower = limited ? model_.jnt_range[2 * id] : -kInfinity;
    const double upper = limited ? model_.jnt_range[2 * id + 1] : kInfinity;
    if (joint.default_position() < lower || joint.default_position() > upper) {
      return Bad(
          absl::StrCat("joint ", Quoted(joint.name()), ": default_position"),
          absl::StrCat("a value in [", lower, ", ", upper, "]"),
          absl::StrCat(joint.default_position()));
    }
    joints.push_back({.name = joint.name(),
                      .joint_id = id,
                      .qpos_address = model_.jnt_qposadr[id],
                      .dof_address = model_.jnt_dofadr[id],
                      .stiffness = joint.stiffness(),
                      .damping = joint.damping(),
                      .torque_limit = joint.torque_limit(),
                      .lower = lower,
                      .upper = upper,
                      .default_position = joint.default_position(),
                      .action_scale = joint.action_scale()});
  }
  return joints;
}

absl::StatusOr<std::vector<int>> Resolver::Tracked() const {
  std::vector<int> tracked;
  if (character_.tracked_bodies().empty()) {
    for (int body = 1; body < model_.nbody; ++body) tracked.push_back(body - 1);
    return tracked;
  }
  for (const std::string& name : character_.tracked_bodies()) {
    SINEW_ASSIGN_OR_RETURN(const int body, Body("tracked_bodies", name));
    if (Contains(tracked, body - 1)) {
      return Bad("tracked_bodies", "each body once", Quoted(name) + " again");
    }
    tracked.push_back(body - 1);
  }
  if (tracked.front() != 0) {
    return Bad(
        "tracked_bodies",
        absl::StrCat("the root ", Quoted(mj_id2name(&model_, mjOBJ_BODY, 1)),
                     " first"),
        Quoted(character_.tracked_bodies(0)));
  }
  return tracked;
}

absl::StatusOr<std::vector<int>> Resolver::Sole(const v1::Foot& foot,
                                                int body) const {
  std::vector<int> sole;
  for (const std::string& name : foot.geoms()) {
    const int geom = mj_name2id(&model_, mjOBJ_GEOM, name.c_str());
    if (geom < 0 || model_.geom_bodyid[geom] != body ||
        !TouchesThings(model_, geom)) {
      return Bad("feet.geoms",
                 absl::StrCat("colliding geoms of body ", Quoted(foot.body())),
                 Quoted(name));
    }
    sole.push_back(geom);
  }
  if (!sole.empty()) return sole;
  for (int geom = 0; geom < model_.ngeom; ++geom) {
    if (model_.geom_bodyid[geom] == body && TouchesThings(model_, geom)) {
      sole.push_back(geom);
    }
  }
  if (sole.empty()) {
    return Bad("feet", "a body with colliding geoms", Quoted(foot.body()));
  }
  return sole;
}

absl::Status Resolver::Feet(std::vector<int>* bodies,
                            std::vector<std::vector<int>>* geoms) const {
  for (const v1::Foot& foot : character_.feet()) {
    SINEW_ASSIGN_OR_RETURN(const int body, Body("feet", foot.body()));
    SINEW_ASSIGN_OR_RETURN(std::vector<int> sole, Sole(foot, body));
    bodies->push_back(body);
    geoms->push_back(std::move(sole));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<int>> Resolver::Terminating(
    const std::vector<int>& tracked, const std::vector<int>& feet) const {
  std::vector<int> exempt;
  for (const std::string& name : character_.termination_exempt_bodies()) {
    SINEW_ASSIGN_OR_RETURN(const int body,
                           Body("termination_exempt_bodies", name));
    if (!Contains(tracked, body - 1)) {
      return Bad("termination_exempt_bodies", "tracked bodies", Quoted(name));
    }
    exempt.push_back(body);
  }
  if (exempt.empty()) exempt = feet;
  std::vector<int> terminating;
  for (size_t i = 0; i < tracked.size(); ++i) {
    if (!Contains(exempt, tracked[i] + 1)) {
      terminating.push_back(static_cast<int>(i));
    }
  }
  return terminating;
}

absl::StatusOr<int> Resolver::Head() const {
  if (character_.head_body().empty()) return -1;
  return Body("head_body", character_.head_body());
}

absl::StatusOr<int> Resolver::Floor() const {
  for (int geom = 0; geom < model_.ngeom; ++geom) {
    if (model_.geom_bodyid[geom] == 0 &&
        model_.geom_type[geom] == mjGEOM_PLANE) {
      return geom;
    }
  }
  return Bad("model", "a plane of the world as floor", "none");
}

absl::Status Resolver::CheckMirrors() const {
  std::set<std::string> joints;
  for (const v1::Joint& joint : character_.joints()) {
    joints.insert(joint.name());
  }
  for (const v1::MirrorPair& pair : character_.mirror_joints()) {
    if (pair.sign() != 1 && pair.sign() != -1) {
      return Bad(absl::StrCat("mirror_joints ", Quoted(pair.left()), ": sign"),
                 "+1 or -1", absl::StrCat(pair.sign()));
    }
    for (const std::string& name : {pair.left(), pair.right()}) {
      if (joints.count(name) == 0) {
        return Bad("mirror_joints", "joints of the character", Quoted(name));
      }
    }
  }
  for (const v1::MirrorPair& pair : character_.mirror_bodies()) {
    for (const std::string& name : {pair.left(), pair.right()}) {
      SINEW_RETURN_IF_ERROR(Body("mirror_bodies", name).status());
    }
  }
  return absl::OkStatus();
}

}  // namespace sinew::character
