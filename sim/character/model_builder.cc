#include "sim/character/model_builder.h"

#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"

namespace sinew::character {
namespace {

// Contact bits: the floor meets bodies, bodies meet bodies if asked to.
constexpr int kFloorBit = 1;
constexpr int kBodyBit = 2;
constexpr double kFloorHalfSize = 0;  // 0: infinite in MuJoCo's convention
constexpr double kFloorGrid = 1;

struct SpecDeleter {
  void operator()(mjSpec* spec) const { mj_deleteSpec(spec); }
};
using SpecPtr = std::unique_ptr<mjSpec, SpecDeleter>;

void RemoveAll(mjSpec* spec, mjtObj type) {
  while (mjsElement* element = mjs_firstElement(spec, type)) {
    mjs_delete(spec, element);
  }
}

void SetOptions(const v1::Physics& physics, mjOption& option) {
  option.timestep = 1 / physics.physics_hz();
  option.integrator = mjINT_EULER;
  option.solver = mjSOL_NEWTON;
  option.iterations = physics.solver_iterations();
  option.ls_iterations = physics.line_search_iterations();
  option.tolerance = physics.solver_tolerance();
  option.cone = mjCONE_PYRAMIDAL;
  option.disableflags |= mjDSBL_ISLAND;
}

void AddFloorIfNone(mjSpec* spec) {
  mjsBody* world = mjs_findBody(spec, "world");
  for (mjsElement* element = mjs_firstChild(world, mjOBJ_GEOM, 0);
       element != nullptr; element = mjs_nextChild(world, element, 0)) {
    if (mjs_asGeom(element)->type == mjGEOM_PLANE) return;
  }
  mjsGeom* floor = mjs_addGeom(world, nullptr);
  mjs_setName(floor->element, "floor");
  floor->type = mjGEOM_PLANE;
  floor->size[0] = kFloorHalfSize;
  floor->size[1] = kFloorHalfSize;
  floor->size[2] = kFloorGrid;
}

void SetContacts(const v1::Physics& physics, mjSpec* spec) {
  mjsBody* world = mjs_findBody(spec, "world");
  for (mjsElement* element = mjs_firstElement(spec, mjOBJ_GEOM);
       element != nullptr; element = mjs_nextElement(spec, element)) {
    mjsGeom* geom = mjs_asGeom(element);
    if (geom->contype == 0 && geom->conaffinity == 0) continue;
    const bool of_world = mjs_getParent(element) == world;
    geom->contype = of_world ? kFloorBit
                             : (physics.self_collision() ? kBodyBit : 0);
    geom->conaffinity =
        of_world ? 0 : kFloorBit | (physics.self_collision() ? kBodyBit : 0);
    geom->condim = 3;
    geom->friction[0] = physics.friction();
  }
}

void SetJoints(const v1::Character& character, mjSpec* spec) {
  for (const v1::Joint& joint : character.joints()) {
    mjsElement* element =
        mjs_findElement(spec, mjOBJ_JOINT, joint.name().c_str());
    // Unknown names are reported, with their list, when names are resolved.
    if (element == nullptr) continue;
    mjs_asJoint(element)->damping[0] = joint.damping();
    if (joint.armature() > 0) mjs_asJoint(element)->armature = joint.armature();
  }
}

// Pairs of bodies that touch in the default pose never collide.
std::set<std::pair<int, int>> TouchingPairs(const mjModel& model) {
  std::set<std::pair<int, int>> pairs;
  const DataPtr data(mj_makeData(&model));
  mj_forward(&model, data.get());
  for (int i = 0; i < data->ncon; ++i) {
    const int first = model.geom_bodyid[data->contact[i].geom[0]];
    const int second = model.geom_bodyid[data->contact[i].geom[1]];
    if (first != 0 && second != 0) {
      pairs.emplace(std::min(first, second), std::max(first, second));
    }
  }
  return pairs;
}

absl::StatusOr<ModelPtr> Compile(mjSpec* spec, const std::string& path) {
  ModelPtr model(mj_compile(spec, nullptr));
  if (model == nullptr) {
    return absl::InvalidArgumentError(
        absl::StrCat("model ", path, ": ", mjs_getError(spec)));
  }
  return model;
}

}  // namespace

absl::StatusOr<ModelPtr> BuildModel(const std::string& mjcf_path,
                                    const v1::Character& character,
                                    const v1::Physics& physics) {
  char error[1000] = "";
  const SpecPtr spec(
      mj_parseXML(mjcf_path.c_str(), nullptr, error, sizeof(error)));
  if (spec == nullptr) {
    return absl::InvalidArgumentError(
        absl::StrCat("model ", mjcf_path, ": ", error));
  }
  RemoveAll(spec.get(), mjOBJ_ACTUATOR);
  RemoveAll(spec.get(), mjOBJ_SENSOR);
  RemoveAll(spec.get(), mjOBJ_KEY);
  SetOptions(physics, spec->option);
  AddFloorIfNone(spec.get());
  SetContacts(physics, spec.get());
  SetJoints(character, spec.get());
  absl::StatusOr<ModelPtr> model = Compile(spec.get(), mjcf_path);
  if (!model.ok() || !physics.self_collision()) return model;

  const std::set<std::pair<int, int>> pairs = TouchingPairs(**model);
  if (pairs.empty()) return model;
  for (const auto& [first, second] : pairs) {
    mjsExclude* exclude = mjs_addExclude(spec.get());
    mjs_setString(exclude->bodyname1,
                  mj_id2name(model->get(), mjOBJ_BODY, first));
    mjs_setString(exclude->bodyname2,
                  mj_id2name(model->get(), mjOBJ_BODY, second));
  }
  return Compile(spec.get(), mjcf_path);
}

}  // namespace sinew::character
