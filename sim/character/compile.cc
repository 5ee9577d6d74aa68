#include "sim/character/compile.h"

#include <mujoco/mujoco.h>

#include <array>
#include <cmath>
#include <memory>
#include <set>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "common/status_macros.h"
#include "sim/character/mujoco_messages.h"
#include "sim/character/scenery.h"

namespace sinew::character {
namespace {

// Contact bits: a pair is tested if one's type meets the other's affinity.
constexpr int kWorldBit = 1;
constexpr int kBodyBit = 2;
// Above the priority of any geom of an MJCF: the floor decides.
constexpr int kFloorPriority = 100;

struct SpecDeleter {
  void operator()(mjSpec* spec) const { mj_deleteSpec(spec); }
};
using SpecPtr = std::unique_ptr<mjSpec, SpecDeleter>;

v1::Physics WithDefaults(v1::Physics physics) {
  if (physics.physics_hz() == 0) physics.set_physics_hz(120);
  if (physics.solver_iterations() == 0) physics.set_solver_iterations(8);
  if (physics.line_search_iterations() == 0) {
    physics.set_line_search_iterations(8);
  }
  if (physics.solver_tolerance() == 0) physics.set_solver_tolerance(1e-6);
  if (physics.friction() == 0) physics.set_friction(1);
  return physics;
}

absl::Status Validate(const v1::Physics& physics) {
  const std::array<std::pair<const char*, double>, 5> fields = {{
      {"physics_hz", physics.physics_hz()},
      {"solver_iterations", physics.solver_iterations()},
      {"line_search_iterations", physics.line_search_iterations()},
      {"solver_tolerance", physics.solver_tolerance()},
      {"friction", physics.friction()},
  }};
  for (const auto& [name, value] : fields) {
    if (!std::isfinite(value) || value <= 0) {
      return absl::InvalidArgumentError(absl::StrCat(
          "recipe field physics.", name, ": expected > 0, found ", value));
    }
  }
  return absl::OkStatus();
}

// Calls `check` with every element of a kind, until it returns an error.
template <typename Check>
absl::Status ForEach(mjSpec* spec, mjtObj type, const Check& check) {
  for (mjsElement* element = mjs_firstElement(spec, type); element != nullptr;
       element = mjs_nextElement(spec, element)) {
    SINEW_RETURN_IF_ERROR(check(element));
  }
  return absl::OkStatus();
}

// MuJoCo takes NaN for a number that was left out, and goes on.
absl::Status CheckFinite(const std::string& path, absl::string_view kind,
                         mjsElement* element, absl::string_view attribute,
                         absl::Span<const double> values) {
  for (const double value : values) {
    if (std::isfinite(value)) continue;
    return absl::InvalidArgumentError(absl::StrCat(
        path, ": ", kind, " \"", mjs_getString(mjs_getName(element)),
        "\": ", attribute, ": expected finite numbers, found ", value));
  }
  return absl::OkStatus();
}

absl::Status CheckJoint(const std::string& path, mjsElement* element) {
  const mjsJoint* joint = mjs_asJoint(element);
  const auto check = [&](absl::string_view attribute,
                         absl::Span<const double> values) {
    return CheckFinite(path, "joint", element, attribute, values);
  };
  SINEW_RETURN_IF_ERROR(check("pos", joint->pos));
  SINEW_RETURN_IF_ERROR(check("axis", joint->axis));
  SINEW_RETURN_IF_ERROR(check("range", joint->range));
  const double lower = joint->range[0], upper = joint->range[1];
  if (lower < upper || (lower == 0 && upper == 0)) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(path, ": joint \"", mjs_getString(mjs_getName(element)),
                   "\": range: expected a lower end and a higher one, found ",
                   lower, " ", upper));
}

absl::Status CheckNumbers(const std::string& path, mjSpec* spec) {
  SINEW_RETURN_IF_ERROR(ForEach(spec, mjOBJ_BODY, [&](mjsElement* element) {
    const mjsBody* body = mjs_asBody(element);
    SINEW_RETURN_IF_ERROR(CheckFinite(path, "body", element, "pos", body->pos));
    return CheckFinite(path, "body", element, "quat", body->quat);
  }));
  SINEW_RETURN_IF_ERROR(ForEach(spec, mjOBJ_GEOM, [&](mjsElement* element) {
    const mjsGeom* geom = mjs_asGeom(element);
    SINEW_RETURN_IF_ERROR(CheckFinite(path, "geom", element, "pos", geom->pos));
    return CheckFinite(path, "geom", element, "quat", geom->quat);
  }));
  return ForEach(spec, mjOBJ_JOINT, [&](mjsElement* element) {
    return CheckJoint(path, element);
  });
}

absl::StatusOr<SpecPtr> Parse(const std::string& path) {
  char error[1000] = "";
  const WarningCollector warnings;
  SpecPtr spec(mj_parseXML(path.c_str(), nullptr, error, sizeof(error)));
  if (spec == nullptr) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": expected an MJCF model, found: ", error));
  }
  SINEW_RETURN_IF_ERROR(CheckNumbers(path, spec.get()));
  return spec;
}

void DeleteAll(mjSpec* spec, mjtObj type) {
  while (mjsElement* element = mjs_firstElement(spec, type)) {
    mjs_delete(spec, element);
  }
}

void Strip(mjSpec* spec) {
  for (mjtObj type : {mjOBJ_ACTUATOR, mjOBJ_SENSOR, mjOBJ_KEY, mjOBJ_PAIR,
                      mjOBJ_CAMERA, mjOBJ_LIGHT}) {
    DeleteAll(spec, type);
  }
}

absl::Status SetJoints(const std::string& path, const v1::Character& character,
                       mjSpec* spec) {
  for (const v1::Joint& settings : character.joints()) {
    mjsJoint* joint = mjs_asJoint(
        mjs_findElement(spec, mjOBJ_JOINT, settings.name().c_str()));
    if (joint == nullptr || joint->type != mjJNT_HINGE) {
      return absl::InvalidArgumentError(absl::StrCat(
          "character \"", character.name(), "\": joints: expected a hinge of ",
          path, ", found \"", settings.name(), "\", ",
          joint == nullptr ? "which it does not have" : "which is no hinge"));
    }
    for (double& coefficient : joint->damping) coefficient = 0;
    joint->damping[0] = settings.damping();
    if (settings.armature() > 0) joint->armature = settings.armature();
  }
  return absl::OkStatus();
}

mjsGeom* FindOrAddFloor(mjSpec* spec) {
  mjsBody* world = mjs_findBody(spec, "world");
  for (mjsElement* element = mjs_firstChild(world, mjOBJ_GEOM, 0);
       element != nullptr; element = mjs_nextChild(world, element, 0)) {
    mjsGeom* geom = mjs_asGeom(element);
    if (geom->type == mjGEOM_PLANE) return geom;
  }
  mjsGeom* floor = mjs_addGeom(world, nullptr);
  mjs_setName(floor->element, "floor");
  floor->type = mjGEOM_PLANE;
  const double size[3] = {0, 0, 0.05};  // infinite; the last is for the eye
  for (int i = 0; i < 3; ++i) floor->size[i] = size[i];
  return floor;
}

// Why this element cannot be a contactless geom; empty: it can.
absl::string_view WhyNotContactless(mjSpec* spec, mjsElement* element) {
  if (element == nullptr) return "it does not have";
  const mjsGeom* geom = mjs_asGeom(element);
  if (geom->contype == 0 && geom->conaffinity == 0) {
    return "touches nothing as it is";
  }
  const bool of_world = mjs_getParent(element) == mjs_findBody(spec, "world");
  return of_world ? "is the world's, not the body's" : "";
}

absl::Status DropContacts(const std::string& path,
                          const v1::Character& character, mjSpec* spec) {
  std::set<absl::string_view> seen;
  for (const std::string& name : character.contactless_geoms()) {
    mjsElement* element = mjs_findElement(spec, mjOBJ_GEOM, name.c_str());
    const absl::string_view why = seen.insert(name).second
                                      ? WhyNotContactless(spec, element)
                                      : "is listed twice";
    if (!why.empty()) {
      return absl::InvalidArgumentError(
          absl::StrCat("character \"", character.name(),
                       "\": contactless_geoms: expected a colliding geom of ",
                       path, ", found \"", name, "\", which ", why));
    }
    mjsGeom* geom = mjs_asGeom(element);
    geom->contype = 0;
    geom->conaffinity = 0;
  }
  return absl::OkStatus();
}

void SetContacts(const v1::Physics& physics, mjSpec* spec) {
  const mjsBody* world = mjs_findBody(spec, "world");
  for (mjsElement* element = mjs_firstElement(spec, mjOBJ_GEOM);
       element != nullptr; element = mjs_nextElement(spec, element)) {
    mjsGeom* geom = mjs_asGeom(element);
    if (geom->contype == 0 && geom->conaffinity == 0) continue;
    if (mjs_getParent(element) == world) {
      geom->contype = kWorldBit;
      geom->conaffinity = 0;
    } else {
      geom->contype = physics.self_collision() ? kBodyBit : 0;
      geom->conaffinity = geom->contype | kWorldBit;
      geom->condim = 1;
    }
  }
  mjsGeom* floor = FindOrAddFloor(spec);
  floor->contype = kWorldBit;
  floor->conaffinity = 0;
  floor->condim = 3;
  floor->priority = kFloorPriority;
  floor->friction[0] = physics.friction();
}

void SetOptions(const v1::Physics& physics, mjOption* option) {
  option->timestep = 1 / physics.physics_hz();
  option->integrator = mjINT_EULER;
  option->solver = mjSOL_NEWTON;
  option->cone = mjCONE_PYRAMIDAL;
  option->iterations = physics.solver_iterations();
  option->ls_iterations = physics.line_search_iterations();
  option->tolerance = physics.solver_tolerance();
  option->disableflags |= mjDSBL_ISLAND;
  option->disableflags &= ~mjDSBL_EULERDAMP;
}

absl::StatusOr<ModelPtr> Compile(const std::string& path, mjSpec* spec) {
  const WarningCollector warnings;
  ModelPtr model(mj_compile(spec, nullptr));
  if (model == nullptr) {
    return absl::InvalidArgumentError(absl::StrCat(
        path, ": expected a model that compiles, found: ", mjs_getError(spec)));
  }
  return model;
}

// Pairs of bodies that interpenetrate at rest or in the default pose, where
// neither is the world.
std::set<std::pair<int, int>> OverlappingBodies(const v1::Character& character,
                                                const mjModel* model) {
  std::set<std::pair<int, int>> pairs;
  const DataPtr data(mj_makeData(model));
  for (const bool default_pose : {false, true}) {
    mj_resetData(model, data.get());
    for (const v1::Joint& joint : character.joints()) {
      const int id = mj_name2id(model, mjOBJ_JOINT, joint.name().c_str());
      if (default_pose) {
        data->qpos[model->jnt_qposadr[id]] = joint.default_position();
      }
    }
    mj_kinematics(model, data.get());
    mj_comPos(model, data.get());
    mj_collision(model, data.get());
    for (int i = 0; i < data->ncon; ++i) {
      const int a = model->geom_bodyid[data->contact[i].geom[0]];
      const int b = model->geom_bodyid[data->contact[i].geom[1]];
      if (a != 0 && b != 0) pairs.insert({a, b});
    }
  }
  return pairs;
}

absl::StatusOr<ModelPtr> ExcludeOverlaps(const std::string& path,
                                         const v1::Character& character,
                                         mjSpec* spec, ModelPtr model) {
  for (const auto& [a, b] : OverlappingBodies(character, model.get())) {
    mjsExclude* exclude = mjs_addExclude(spec);
    mjs_setString(exclude->bodyname1, mj_id2name(model.get(), mjOBJ_BODY, a));
    mjs_setString(exclude->bodyname2, mj_id2name(model.get(), mjOBJ_BODY, b));
  }
  return Compile(path, spec);
}

absl::Status CheckBodiesHaveNames(const std::string& path,
                                  const mjModel* model) {
  for (int body = 1; body < model->nbody; ++body) {
    const char* name = mj_id2name(model, mjOBJ_BODY, body);
    if (name == nullptr || *name == '\0') {
      return absl::InvalidArgumentError(absl::StrCat(
          path, ": expected a name for every body, found none for body ", body,
          " of ", model->nbody - 1));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<ModelPtr> CompileModel(const std::string& path,
                                      const v1::Character& character,
                                      const v1::Physics& physics,
                                      Purpose purpose) {
  const v1::Physics settings = WithDefaults(physics);
  SINEW_RETURN_IF_ERROR(Validate(settings));
  SINEW_ASSIGN_OR_RETURN(SpecPtr spec, Parse(path));
  Strip(spec.get());
  SINEW_RETURN_IF_ERROR(SetJoints(path, character, spec.get()));
  SINEW_RETURN_IF_ERROR(DropContacts(path, character, spec.get()));
  SetContacts(settings, spec.get());
  SetOptions(settings, &spec->option);
  if (purpose == Purpose::kPhysics) {
    spec->compiler.discardvisual = 1;
  } else {
    AddScenery(spec.get());
  }
  SINEW_ASSIGN_OR_RETURN(ModelPtr model, Compile(path, spec.get()));
  SINEW_RETURN_IF_ERROR(CheckBodiesHaveNames(path, model.get()));
  if (!settings.self_collision()) return model;
  return ExcludeOverlaps(path, character, spec.get(), std::move(model));
}

}  // namespace sinew::character
