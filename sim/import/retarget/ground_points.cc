#include "sim/import/retarget/ground_points.h"

#include <cmath>
#include <numbers>
#include <set>

#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr int kRimSamples = 8;

// Directions spread evenly over the sphere (Fibonacci lattice).
std::vector<Vector3d> Directions(int count) {
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  std::vector<Vector3d> directions;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - 2 * (i + 0.5) / count;
    const double radius = std::sqrt(1 - z * z);
    directions.emplace_back(radius * std::cos(golden * i),
                            radius * std::sin(golden * i), z);
  }
  return directions;
}

// Points of one geom, in the geom's frame.
class GeomPoints {
 public:
  GeomPoints(const mjModel& model, int geom)
      : model_(model), geom_(geom), size_(model.geom_size + 3 * geom) {}

  // Calls add(position, radius).
  template <typename Add>
  void Visit(const Add& add) const {
    switch (model_.geom_type[geom_]) {
      case mjGEOM_SPHERE:
        add(Vector3d::Zero(), size_[0]);
        break;
      case mjGEOM_CAPSULE:
        add(Vector3d(0, 0, size_[1]), size_[0]);
        add(Vector3d(0, 0, -size_[1]), size_[0]);
        break;
      case mjGEOM_BOX:
        for (int i = 0; i < 8; ++i) {
          add(Vector3d(i & 1 ? size_[0] : -size_[0],
                       i & 2 ? size_[1] : -size_[1],
                       i & 4 ? size_[2] : -size_[2]),
              0.0);
        }
        break;
      case mjGEOM_CYLINDER:
        VisitCylinder(add);
        break;
      case mjGEOM_ELLIPSOID:
        for (const Vector3d& d : Directions(32)) {
          const Vector3d axes(size_[0], size_[1], size_[2]);
          const Vector3d scaled = axes.cwiseProduct(d);
          add(Vector3d(axes.cwiseProduct(scaled) / scaled.norm()), 0.0);
        }
        break;
      case mjGEOM_MESH:
        VisitMesh(add);
        break;
      default:
        break;
    }
  }

 private:
  template <typename Add>
  void VisitCylinder(const Add& add) const {
    for (int i = 0; i < kRimSamples; ++i) {
      const double angle = 2 * std::numbers::pi * i / kRimSamples;
      for (const double end : {size_[1], -size_[1]}) {
        add(Vector3d(size_[0] * std::cos(angle), size_[0] * std::sin(angle),
                     end),
            0.0);
      }
    }
  }

  template <typename Add>
  void VisitMesh(const Add& add) const {
    const int mesh = model_.geom_dataid[geom_];
    const float* vertices = model_.mesh_vert + 3 * model_.mesh_vertadr[mesh];
    std::set<int> extreme;
    for (const Vector3d& direction : Directions(64)) {
      int best = 0;
      double most = -INFINITY;
      for (int v = 0; v < model_.mesh_vertnum[mesh]; ++v) {
        const double along = direction.x() * vertices[3 * v] +
                             direction.y() * vertices[3 * v + 1] +
                             direction.z() * vertices[3 * v + 2];
        if (along > most) {
          most = along;
          best = v;
        }
      }
      extreme.insert(best);
    }
    for (const int v : extreme) {
      add(Vector3d(vertices[3 * v], vertices[3 * v + 1], vertices[3 * v + 2]),
          0.0);
    }
  }

  const mjModel& model_;
  const int geom_;
  const mjtNum* size_;
};

// Whether MuJoCo's filter lets the two geoms collide.
bool Collide(const mjModel& model, int a, int b) {
  return (model.geom_contype[a] & model.geom_conaffinity[b]) != 0 ||
         (model.geom_contype[b] & model.geom_conaffinity[a]) != 0;
}

}  // namespace

std::vector<GroundPoint> MakeGroundPoints(const mjModel& model,
                                          int floor_geom) {
  std::vector<GroundPoint> points;
  for (int geom = 0; geom < model.ngeom; ++geom) {
    const int body = model.geom_bodyid[geom];
    if (body == 0 || !Collide(model, geom, floor_geom)) continue;
    const Vector3d origin =
        Eigen::Map<const Vector3d>(model.geom_pos + 3 * geom);
    const Quaterniond frame = motion::FromWxyz(model.geom_quat + 4 * geom);
    GeomPoints(model, geom).Visit([&](const Vector3d& local, double radius) {
      points.push_back({body, origin + frame * local, radius});
    });
  }
  return points;
}

}  // namespace sinew::import
