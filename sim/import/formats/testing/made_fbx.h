#ifndef SINEW_SIM_IMPORT_FORMATS_TESTING_MADE_FBX_H_
#define SINEW_SIM_IMPORT_FORMATS_TESTING_MADE_FBX_H_

#include <Eigen/Geometry>
#include <string>
#include <vector>

namespace sinew::import::testing {

// A small body with Mixamo's names and habits (a T-pose, y up, centimetres,
// joint frames that lie along the bones), which turns and moves; written as
// text by the FBX library's own exporter (binary_fbx.h makes binary files of
// it).
struct MadeFbx {
  std::string bytes;
  std::vector<std::string> joints;
  std::vector<int> parents;
  // [frames][joints] in the file's world and units; the first is not the rest
  // pose.
  std::vector<std::vector<Eigen::Affine3d>> world;
  std::vector<Eigen::Affine3d> rest;
  double frames_per_second;
};

struct MadeFbxOptions {
  // With a mesh that is bound in the rest pose; without, the nodes' still pose
  // is that.
  bool mesh = true;
  int frames = 25;
  double frames_per_second = 24;  // of keys; the exporter always states 24
  double centimetres_per_unit = 1;
  int up_axis = 1;  // 0, 1, 2: x, y, z
};

MadeFbx MakeFbx(const MadeFbxOptions& options = {});

}  // namespace sinew::import::testing

#endif  // SINEW_SIM_IMPORT_FORMATS_TESTING_MADE_FBX_H_
