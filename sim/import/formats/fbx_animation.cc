#include "sim/import/formats/fbx_animation.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/status_macros.h"
#include "sim/import/formats/text_lines.h"

namespace sinew::import {
namespace {

using Eigen::Affine3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr size_t kMaxNodes = 20000;
constexpr double kMaxNumber = 1e9;
// What the library puts into the names of the nodes that it adds.
constexpr char kPivotMark[] = "_$AssimpFbx$";

absl::Status Error(absl::string_view source, absl::string_view what) {
  return absl::InvalidArgumentError(absl::StrCat(source, ": ", what));
}

Affine3d ToEigen(const aiMatrix4x4& m) {
  Affine3d transform;
  transform.matrix() << m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1,
      m.c2, m.c3, m.c4, 0, 0, 0, 1;
  return transform;
}

Quaterniond ToEigen(const aiQuaternion& q) {
  return Quaterniond(q.w, q.x, q.y, q.z);
}

bool IsGood(const Affine3d& transform) {
  return (transform.matrix().array().abs() <= kMaxNumber).all();
}

Vector3d Value(const aiVectorKey& key) {
  return {key.mValue.x, key.mValue.y, key.mValue.z};
}
Quaterniond Value(const aiQuatKey& key) {
  return ToEigen(key.mValue).normalized();
}

bool IsGood(const aiVectorKey& key) {
  return (Value(key).array().abs() <= kMaxNumber).all();
}
bool IsGood(const aiQuatKey& key) {
  const double norm = ToEigen(key.mValue).norm();
  return norm > 1e-3 && norm < 1e3;
}

// Finite values at times that do not fall.
template <typename Key>
bool AreGood(std::span<const Key> keys) {
  for (size_t i = 0; i < keys.size(); ++i) {
    if (!(std::abs(keys[i].mTime) <= 1e15) || !IsGood(keys[i]) ||
        (i > 0 && keys[i].mTime < keys[i - 1].mTime)) {
      return false;
    }
  }
  return true;
}

Vector3d Between(const Vector3d& a, const Vector3d& b, double share) {
  return a + share * (b - a);
}
Quaterniond Between(const Quaterniond& a, const Quaterniond& b, double share) {
  return a.slerp(share, b);
}

// Value at a time; the first or last before or after them. Precondition: keys.
template <typename Key>
auto Sample(std::span<const Key> keys, double tick) {
  const auto after = std::upper_bound(
      keys.begin(), keys.end(), tick,
      [](double time, const Key& key) { return time < key.mTime; });
  if (after == keys.begin()) return Value(keys.front());
  if (after == keys.end()) return Value(keys.back());
  const Key& before = *(after - 1);
  return Between(Value(before), Value(*after),
                 (tick - before.mTime) / (after->mTime - before.mTime));
}

std::span<const aiVectorKey> Positions(const aiNodeAnim& channel) {
  return {channel.mPositionKeys, channel.mNumPositionKeys};
}
std::span<const aiQuatKey> Rotations(const aiNodeAnim& channel) {
  return {channel.mRotationKeys, channel.mNumRotationKeys};
}
std::span<const aiVectorKey> Scalings(const aiNodeAnim& channel) {
  return {channel.mScalingKeys, channel.mNumScalingKeys};
}

bool AreGood(const aiNodeAnim& channel) {
  return AreGood(Positions(channel)) && AreGood(Rotations(channel)) &&
         AreGood(Scalings(channel)) && channel.mNumPositionKeys > 0 &&
         channel.mNumRotationKeys > 0 && channel.mNumScalingKeys > 0;
}

// The time that keys are spread over. The library adds single keys, at any
// time, to what does not move; they count only where nothing moves.
struct Span {
  bool any = false, any_moves = false;
  double start = 0, end = 0;

  template <typename Key>
  void Extend(std::span<const Key> keys) {
    const bool moves = keys.size() > 1;
    if (any_moves && !moves) return;
    const double first = keys.front().mTime;
    const double last = moves ? keys.back().mTime : first;
    const bool is_new = !any || (moves && !any_moves);
    start = is_new ? first : std::min(start, first);
    end = is_new ? last : (moves ? std::max(end, last) : start);
    any = true;
    any_moves = moves;
  }
};

Affine3d Local(const FbxNode& node, double tick) {
  if (node.channel == nullptr) return node.still;
  return Eigen::Translation3d(Sample(Positions(*node.channel), tick)) *
         Sample(Rotations(*node.channel), tick) *
         Eigen::Scaling(Sample(Scalings(*node.channel), tick));
}

// The longest animation of those with most channels; -1: none has any.
int ChooseAnimation(const aiScene& scene) {
  int best = -1;
  for (unsigned i = 0; i < scene.mNumAnimations; ++i) {
    const aiAnimation& animation = *scene.mAnimations[i];
    if (animation.mNumChannels == 0) continue;
    if (best < 0 || std::pair(animation.mNumChannels, animation.mDuration) >
                        std::pair(scene.mAnimations[best]->mNumChannels,
                                  scene.mAnimations[best]->mDuration)) {
      best = static_cast<int>(i);
    }
  }
  return best;
}

}  // namespace

absl::StatusOr<FbxAnimation> FbxAnimation::Create(
    const aiScene& scene, absl::string_view source,
    std::vector<std::string>* warnings) {
  const int chosen = ChooseAnimation(scene);
  if (scene.mRootNode == nullptr || chosen < 0) {
    return Error(source, "expected an animation, found none");
  }
  for (unsigned i = 0; i < scene.mNumAnimations; ++i) {
    const aiAnimation& other = *scene.mAnimations[i];
    if (static_cast<int>(i) == chosen || other.mNumChannels == 0) continue;
    warnings->push_back(
        absl::StrCat("of several animations, ",
                     Quoted(scene.mAnimations[chosen]->mName.C_Str()),
                     " is read and ", Quoted(other.mName.C_Str()), " is not"));
  }
  FbxAnimation animation;
  SINEW_RETURN_IF_ERROR(animation.AddNodes(scene, source));
  NodesByName by_name;
  for (size_t i = 0; i < animation.nodes_.size(); ++i) {
    by_name.emplace(animation.nodes_[i].name, static_cast<int>(i));
  }
  SINEW_RETURN_IF_ERROR(
      animation.AddChannels(*scene.mAnimations[chosen], by_name, source));
  animation.AddBinds(scene, by_name);
  animation.FindReplacedPivots();
  return animation;
}

absl::Status FbxAnimation::AddNodes(const aiScene& scene,
                                    absl::string_view source) {
  struct Entry {
    const aiNode* node;
    int parent;
  };
  std::vector<Entry> stack;
  const auto push_children = [&stack](const aiNode& node, int parent) {
    for (unsigned i = node.mNumChildren; i > 0; --i) {
      stack.push_back({node.mChildren[i - 1], parent});
    }
  };
  // The root's transform is the library's, not the file's: it turns and scales
  // the scene to what the library prefers.
  push_children(*scene.mRootNode, -1);
  while (!stack.empty()) {
    const Entry entry = stack.back();
    stack.pop_back();
    if (nodes_.size() == kMaxNodes) {
      return Error(source,
                   absl::StrCat("expected at most ", kMaxNodes, " nodes"));
    }
    FbxNode node{.name = entry.node->mName.C_Str(),
                 .parent = entry.parent,
                 .has_mesh = entry.node->mNumMeshes > 0,
                 .still = ToEigen(entry.node->mTransformation),
                 .bind = std::nullopt};
    node.is_pivot = absl::StrContains(node.name, kPivotMark);
    if (!IsGood(node.still)) {
      return Error(source, absl::StrCat("node ", Quoted(node.name),
                                        ": expected finite numbers"));
    }
    nodes_.push_back(std::move(node));
    push_children(*entry.node, static_cast<int>(nodes_.size()) - 1);
  }
  return absl::OkStatus();
}

absl::Status FbxAnimation::AddChannels(const aiAnimation& animation,
                                       const NodesByName& by_name,
                                       absl::string_view source) {
  if (animation.mTicksPerSecond > 0) {
    ticks_per_second_ = animation.mTicksPerSecond;
  }
  Span span;
  std::vector<double> steps;  // s between keys
  for (unsigned i = 0; i < animation.mNumChannels; ++i) {
    const aiNodeAnim& channel = *animation.mChannels[i];
    const auto node = by_name.find(channel.mNodeName.C_Str());
    if (node == by_name.end()) continue;
    if (!AreGood(channel)) {
      return Error(source,
                   absl::StrCat("animation of ", Quoted(node->first),
                                ": expected finite keys in order of time"));
    }
    nodes_[node->second].channel = &channel;
    span.Extend(Positions(channel));
    const auto rotations = Rotations(channel);
    span.Extend(rotations);
    for (size_t k = 1; k < rotations.size(); ++k) {
      const double step = rotations[k].mTime - rotations[k - 1].mTime;
      if (step > 0) steps.push_back(step / ticks_per_second_);
    }
  }
  if (!steps.empty()) {
    const auto middle = steps.begin() + steps.size() / 2;
    std::nth_element(steps.begin(), middle, steps.end());
    keys_per_second_ = 1 / *middle;
  }
  if (!span.any) {
    return Error(source, "expected an animation of its nodes, found none");
  }
  start_ = span.start;
  end_ = span.end;
  return absl::OkStatus();
}

void FbxAnimation::AddBinds(const aiScene& scene, const NodesByName& by_name) {
  const std::vector<Affine3d> still = Still();
  struct Entry {
    const aiNode* node;
    Affine3d world;
  };
  std::vector<Entry> stack = {{scene.mRootNode, Affine3d::Identity()}};
  while (!stack.empty()) {
    const Entry entry = stack.back();
    stack.pop_back();
    for (unsigned i = 0; i < entry.node->mNumMeshes; ++i) {
      const aiMesh& mesh = *scene.mMeshes[entry.node->mMeshes[i]];
      for (unsigned k = 0; k < mesh.mNumBones; ++k) {
        const aiBone& bone = *mesh.mBones[k];
        const auto node = by_name.find(bone.mName.C_Str());
        const Affine3d offset = ToEigen(bone.mOffsetMatrix);
        if (node == by_name.end() || !IsGood(offset) ||
            std::abs(offset.linear().determinant()) < 1e-12) {
          continue;
        }
        const Affine3d bind = entry.world * offset.inverse();
        if (IsGood(bind)) nodes_[node->second].bind = bind;
      }
    }
    for (unsigned i = 0; i < entry.node->mNumChildren; ++i) {
      const aiNode* child = entry.node->mChildren[i];
      const auto node = by_name.find(child->mName.C_Str());
      stack.push_back(
          {child, node == by_name.end() ? entry.world : still[node->second]});
    }
  }
}

void FbxAnimation::FindReplacedPivots() {
  for (const FbxNode& node : nodes_) {
    if (node.is_pivot || node.channel == nullptr) continue;
    for (int above = node.parent; above >= 0 && nodes_[above].is_pivot;
         above = nodes_[above].parent) {
      nodes_[above].is_replaced = true;
    }
  }
}

std::vector<Affine3d> FbxAnimation::Still() const {
  std::vector<Affine3d> world;
  world.reserve(nodes_.size());
  for (const FbxNode& node : nodes_) {
    world.push_back(node.parent < 0 ? node.still
                                    : world[node.parent] * node.still);
  }
  return world;
}

std::vector<Affine3d> FbxAnimation::At(double seconds) const {
  const double tick = start_ + seconds * ticks_per_second_;
  std::vector<Affine3d> world;
  world.reserve(nodes_.size());
  for (const FbxNode& node : nodes_) {
    const Affine3d local =
        node.is_replaced ? Affine3d::Identity() : Local(node, tick);
    world.push_back(node.parent < 0 ? local : world[node.parent] * local);
  }
  return world;
}

}  // namespace sinew::import
