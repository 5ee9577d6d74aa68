#ifndef SINEW_SIM_IMPORT_FORMATS_FBX_SKELETON_H_
#define SINEW_SIM_IMPORT_FORMATS_FBX_SKELETON_H_

#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "sim/import/formats/fbx_animation.h"

namespace sinew::import {

// The nodes of an animation that are a skeleton.
struct FbxSkeleton {
  std::vector<int> nodes;    // parents before children; [0] is the root
  std::vector<int> parents;  // [nodes] index into nodes; root -1
};

// Joints are the nodes that move (by themselves or by their pivots) or that a
// mesh is bound to, without those that only show a mesh; what lies between two
// of them; and what lies below them. The root is the node that moves through
// the world: where what holds all joints has a single child that moves along
// it, that child. INVALID_ARGUMENT naming `source`: no such nodes.
absl::StatusOr<FbxSkeleton> FindFbxSkeleton(const FbxAnimation& animation,
                                            absl::string_view source);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_FBX_SKELETON_H_
