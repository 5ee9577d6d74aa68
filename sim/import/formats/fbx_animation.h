#ifndef SINEW_SIM_IMPORT_FORMATS_FBX_ANIMATION_H_
#define SINEW_SIM_IMPORT_FORMATS_FBX_ANIMATION_H_

#include <assimp/scene.h>

#include <Eigen/Geometry>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace sinew::import {

// A node of the file, in its own units and axes.
struct FbxNode {
  std::string name;
  int parent = -1;  // index, less than this one's; -1: below the scene's root
  // One of those that the library puts above a node for its pivots, pre- and
  // post-rotation.
  bool is_pivot = false;
  // A pivot whose node has an animation of its own, under its own name: the
  // library (5.2) puts all of the chain, pre-rotation included, into that.
  bool is_replaced = false;
  bool has_mesh = false;
  Eigen::Affine3d still;  // in the parent, without animation
  // In the world, when a mesh was bound to it; set only after still poses.
  std::optional<Eigen::Affine3d> bind;
  const aiNodeAnim* channel = nullptr;
};

// One animation of a scene that the library has read, in a form that is known
// good: parents before children, finite numbers, rising times.
//
// Thread-safety: immutable. Ownership: borrows the scene. Blocking: never.
// Errors: Create.
class FbxAnimation {
 public:
  // The animation that moves most nodes, the longest of these. Names the others
  // in `warnings`. INVALID_ARGUMENT naming `source`, expected and found.
  static absl::StatusOr<FbxAnimation> Create(
      const aiScene& scene, absl::string_view source,
      std::vector<std::string>* warnings);

  const std::vector<FbxNode>& nodes() const { return nodes_; }
  double seconds() const { return (end_ - start_) / ticks_per_second_; }
  // Keys a second of the rotations, 0 if none has two: from the median step,
  // since the library adds keys where a rotation takes more than half a turn.
  double keys_per_second() const { return keys_per_second_; }

  // World transforms of all nodes at rest, and at a time of the animation, s.
  std::vector<Eigen::Affine3d> Still() const;
  std::vector<Eigen::Affine3d> At(double seconds) const;

 private:
  // Indices into nodes_; of several nodes of a name, the first.
  using NodesByName = std::map<absl::string_view, int>;

  FbxAnimation() = default;
  absl::Status AddNodes(const aiScene& scene, absl::string_view source);
  absl::Status AddChannels(const aiAnimation& animation,
                           const NodesByName& by_name,
                           absl::string_view source);
  void AddBinds(const aiScene& scene, const NodesByName& by_name);
  void FindReplacedPivots();

  std::vector<FbxNode> nodes_;
  double ticks_per_second_ = 1;
  double start_ = 0, end_ = 0;  // ticks
  double keys_per_second_ = 0;
};

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_FBX_ANIMATION_H_
