#include "sim/import/formats/smpl_skeleton.h"

#include "sim/import/formats/axes.h"

namespace sinew::import {
namespace {

struct Joint {
  const char* name;
  int parent;
  double location[3];  // m; x left, y up, z forward
};

constexpr Joint kJoints[] = {
    {"pelvis", -1, {-0.0018, -0.2233, 0.0282}},
    {"left_hip", 0, {0.0677, -0.3147, 0.0214}},
    {"right_hip", 0, {-0.0695, -0.3139, 0.0239}},
    {"spine1", 0, {-0.0043, -0.1144, 0.0015}},
    {"left_knee", 1, {0.1020, -0.6899, 0.0169}},
    {"right_knee", 2, {-0.1078, -0.6964, 0.0150}},
    {"spine2", 3, {0.0012, 0.0208, 0.0026}},
    {"left_ankle", 4, {0.0884, -1.0879, -0.0268}},
    {"right_ankle", 5, {-0.0920, -1.0948, -0.0273}},
    {"spine3", 6, {0.0026, 0.0737, 0.0280}},
    {"left_foot", 7, {0.1148, -1.1437, 0.0925}},
    {"right_foot", 8, {-0.1174, -1.1430, 0.0961}},
    {"neck", 9, {-0.0002, 0.2876, -0.0148}},
    {"left_collar", 9, {0.0815, 0.1955, -0.0060}},
    {"right_collar", 9, {-0.0791, 0.1926, -0.0106}},
    {"head", 12, {0.0050, 0.3526, 0.0365}},
    {"left_shoulder", 13, {0.1724, 0.2260, -0.0149}},
    {"right_shoulder", 14, {-0.1752, 0.2251, -0.0197}},
    {"left_elbow", 16, {0.4321, 0.2132, -0.0424}},
    {"right_elbow", 17, {-0.4289, 0.2118, -0.0411}},
    {"left_wrist", 18, {0.6813, 0.2222, -0.0435}},
    {"right_wrist", 19, {-0.6842, 0.2196, -0.0467}},
    {"left_hand", 20, {0.7653, 0.2140, -0.0585}},
    {"right_hand", 21, {-0.7688, 0.2134, -0.0570}},
};

Eigen::Vector3d Location(int joint) {
  return Eigen::Vector3d(kJoints[joint].location);
}

SourceSkeleton MakeSkeleton() {
  SourceSkeleton skeleton;
  for (const Joint& joint : kJoints) {
    const int index = static_cast<int>(skeleton.joints.size());
    Eigen::Vector3d offset = Eigen::Vector3d::Zero();
    if (joint.parent >= 0) {
      offset = ToZUp('y') * (Location(index) - Location(joint.parent));
    }
    skeleton.joints.push_back({.name = joint.name,
                               .parent = joint.parent,
                               .offset = offset,
                               .is_end = index >= kSmplBodyJoints});
  }
  return skeleton;
}

}  // namespace

const SourceSkeleton& SmplSkeleton() {
  static const SourceSkeleton& skeleton = *new SourceSkeleton(MakeSkeleton());
  return skeleton;
}

Eigen::Vector3d SmplPelvis() { return Location(0); }

}  // namespace sinew::import
