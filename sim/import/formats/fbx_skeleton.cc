#include "sim/import/formats/fbx_skeleton.h"

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace sinew::import {
namespace {

// A child that moves along its parent by more than this share of the skeleton
// carries the motion through the world.
constexpr double kMoves = 0.01;
constexpr int kSamples = 50;
// A branch with so much more joints than all others is the body.
constexpr int kDominance = 4;

class Finder {
 public:
  explicit Finder(const FbxAnimation& animation)
      : animation_(animation),
        nodes_(animation.nodes()),
        parents_(nodes_.size(), -1),
        is_joint_(nodes_.size(), false),
        count_(nodes_.size() + 1, 0) {
    MarkJoints();
    CountJoints();
  }

  FbxSkeleton Find() const {
    FbxSkeleton skeleton;
    const int root = FindRoot();
    if (root < 0) return skeleton;
    std::vector<int> index(nodes_.size(), -1);
    for (int node = root; node < Size(); ++node) {
      const bool is_root = node == root;
      if (nodes_[node].is_pivot) continue;
      if (!is_root && (parents_[node] < 0 || index[parents_[node]] < 0)) {
        continue;
      }
      if (!is_root && nodes_[node].has_mesh && count_[node] == 0) continue;
      index[node] = static_cast<int>(skeleton.nodes.size());
      skeleton.nodes.push_back(node);
      skeleton.parents.push_back(is_root ? -1 : index[parents_[node]]);
    }
    return skeleton;
  }

 private:
  int Size() const { return static_cast<int>(nodes_.size()); }

  // Parents that are no pivots, and which nodes move or are bound.
  void MarkJoints() {
    for (int node = 0; node < Size(); ++node) {
      bool moves = nodes_[node].channel != nullptr;
      int parent = nodes_[node].parent;
      while (parent >= 0 && nodes_[parent].is_pivot) {
        moves = moves || nodes_[parent].channel != nullptr;
        parent = nodes_[parent].parent;
      }
      parents_[node] = parent;
      is_joint_[node] =
          !nodes_[node].is_pivot &&
          (nodes_[node].bind.has_value() || (moves && !nodes_[node].has_mesh));
    }
  }

  // Joints at and below each node; the scene's root is the last entry.
  void CountJoints() {
    for (int node = Size() - 1; node >= 0; --node) {
      if (nodes_[node].is_pivot) continue;
      count_[node] += is_joint_[node] ? 1 : 0;
      count_[parents_[node] < 0 ? Size() : parents_[node]] += count_[node];
    }
  }

  // The child with most joints below it, and the joints of all others.
  int LargestChild(int parent, int* others) const {
    int largest = -1;
    int all = 0;
    for (int node = 0; node < Size(); ++node) {
      if (nodes_[node].is_pivot || parents_[node] != parent) continue;
      all += count_[node];
      if (count_[node] > 0 && (largest < 0 || count_[node] > count_[largest])) {
        largest = node;
      }
    }
    *others = largest < 0 ? 0 : all - count_[largest];
    return largest;
  }

  int FindRoot() const {
    int others = 0;
    int root = LargestChild(-1, &others);
    while (root >= 0) {
      const int child = LargestChild(root, &others);
      if (child < 0) break;
      const bool descends = is_joint_[root]
                                ? others == 0 && MovesAlong(child, root)
                                : count_[child] >= kDominance * others;
      if (!descends) break;
      root = child;
    }
    return root;
  }

  // Whether the node's place in its parent changes over the animation.
  bool MovesAlong(int node, int parent) const {
    Eigen::AlignedBox3d places, extent;
    for (int i = 0; i <= kSamples; ++i) {
      const auto world = animation_.At(animation_.seconds() * i / kSamples);
      places.extend(world[parent].inverse(Eigen::Affine) *
                    world[node].translation());
      if (i > 0) continue;
      const Eigen::Affine3d to_parent = world[parent].inverse(Eigen::Affine);
      for (int k = 0; k < Size(); ++k) {
        if (is_joint_[k]) extent.extend(to_parent * world[k].translation());
      }
    }
    return places.diagonal().norm() > kMoves * extent.diagonal().norm();
  }

  const FbxAnimation& animation_;
  const std::vector<FbxNode>& nodes_;
  std::vector<int> parents_;  // the nearest that is no pivot; -1: the scene
  std::vector<bool> is_joint_;
  std::vector<int> count_;
};

}  // namespace

absl::StatusOr<FbxSkeleton> FindFbxSkeleton(const FbxAnimation& animation,
                                            absl::string_view source) {
  FbxSkeleton skeleton = Finder(animation).Find();
  if (skeleton.nodes.size() < 2) {
    return absl::InvalidArgumentError(
        absl::StrCat(source, ": expected a skeleton that moves, found ",
                     skeleton.nodes.size(), " moving nodes"));
  }
  return skeleton;
}

}  // namespace sinew::import
