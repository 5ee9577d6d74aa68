#include "tools/motion_report/body_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace sinew::motion_report {
namespace {

using Json = nlohmann::json;

// Radius of what stands for a body without geoms, m.
constexpr double kBoneRadius = 0.025;
// A mesh this much longer than wide is a capsule, else a box.
constexpr double kSlender = 1.5;

// To a tenth of a millimetre: shorter in the page.
double Rounded(double value) { return std::round(1e4 * value) / 1e4; }

Json Numbers(const double* values, int count) {
  Json numbers = Json::array();
  for (int i = 0; i < count; ++i) numbers.push_back(Rounded(values[i]));
  return numbers;
}

Json Shape(const char* type, const std::array<double, 3>& size,
           const double* position, const double* rotation) {
  return {{"type", type},
          {"size", Numbers(size.data(), 3)},
          {"position", Numbers(position, 3)},
          {"rotation", Numbers(rotation, 4)}};
}

// The capsule or box around a mesh, from its extents in the geom's frame.
Json MeshShape(const mjModel& model, int geom) {
  const double* box = model.geom_aabb + 6 * geom;
  const double* quat = model.geom_quat + 4 * geom;
  std::array<double, 3> half = {box[3], box[4], box[5]};
  double centre[3];
  mju_rotVecQuat(centre, box, quat);
  mju_addTo3(centre, model.geom_pos + 3 * geom);
  const auto longest = static_cast<int>(
      std::max_element(half.begin(), half.end()) - half.begin());
  const double radius = (half[0] + half[1] + half[2] - half[longest]) / 2;
  if (half[longest] < kSlender * radius) {
    return Shape("box", half, centre, quat);
  }
  // From z to the long axis.
  std::array<double, 3> axis = {0, 0, 0};
  axis[longest] = 1;
  double turn[4], rotation[4];
  mju_quatZ2Vec(turn, axis.data());
  mju_mulQuat(rotation, quat, turn);
  return Shape("capsule", {radius, half[longest] - radius, 0}, centre,
               rotation);
}

// Null for what has no shape here (planes, height fields).
Json GeomShape(const mjModel& model, int geom) {
  const double* size = model.geom_size + 3 * geom;
  const auto make = [&](const char* type) {
    return Shape(type, {size[0], size[1], size[2]}, model.geom_pos + 3 * geom,
                 model.geom_quat + 4 * geom);
  };
  switch (model.geom_type[geom]) {
    case mjGEOM_SPHERE:
      return make("sphere");
    case mjGEOM_CAPSULE:
      return make("capsule");
    case mjGEOM_CYLINDER:
      return make("cylinder");
    case mjGEOM_BOX:
      return make("box");
    case mjGEOM_ELLIPSOID:
      return make("ellipsoid");
    case mjGEOM_MESH:
      return MeshShape(model, geom);
    default:
      return {};
  }
}

// A capsule from the body's origin to a child's.
Json BoneShape(const mjModel& model, int child) {
  const double* offset = model.body_pos + 3 * child;
  const double length = mju_norm3(offset);
  if (length < kBoneRadius) return {};
  double centre[3], rotation[4];
  mju_scl3(centre, offset, 0.5);
  mju_quatZ2Vec(rotation, offset);
  return Shape("capsule", {kBoneRadius, length / 2, 0}, centre, rotation);
}

Json Shapes(const mjModel& model, int body) {
  Json shapes = Json::array();
  const int begin = model.body_geomadr[body];
  for (int i = 0; i < model.body_geomnum[body]; ++i) {
    if (Json shape = GeomShape(model, begin + i); !shape.is_null()) {
      shapes.push_back(std::move(shape));
    }
  }
  if (!shapes.empty()) return shapes;
  for (int child = body + 1; child < model.nbody; ++child) {
    if (model.body_parentid[child] != body) continue;
    if (Json shape = BoneShape(model, child); !shape.is_null()) {
      shapes.push_back(std::move(shape));
    }
  }
  return shapes;
}

}  // namespace

Json BodyShapes(const mjModel& model) {
  Json bodies = Json::array();
  for (int body = 1; body < model.nbody; ++body) {
    const char* name = mj_id2name(&model, mjOBJ_BODY, body);
    bodies.push_back({{"name", name == nullptr ? "" : name},
                      {"shapes", Shapes(model, body)}});
  }
  return bodies;
}

}  // namespace sinew::motion_report
