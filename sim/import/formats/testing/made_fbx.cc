#include "sim/import/formats/testing/made_fbx.h"

#include <assimp/scene.h>

#include <assimp/Exporter.hpp>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "absl/strings/string_view.h"
#include "common/check.h"

namespace sinew::import::testing {
namespace {

using Eigen::Affine3d;
using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;

struct Joint {
  const char* name;
  int parent;
  double place[3];  // in the world at rest, cm
  // Of the joint's frame at rest, in the world: rotation vector.
  double frame[3];
  double swing;  // rad, largest angle from rest
};

constexpr Joint kJoints[] = {
    {"mixamorig:Hips", -1, {0, 100, 0}, {0, 0, 0}, 0.3},
    {"mixamorig:Spine", 0, {0, 112, -1}, {0.1, 0, 0}, 0.2},
    {"mixamorig:Neck", 1, {0, 148, 0}, {-0.1, 0, 0}, 0.3},
    {"mixamorig:Head", 2, {0, 158, 2}, {0, 0, 0}, 0.4},
    {"mixamorig:HeadTop_End", 3, {0, 178, 4}, {0, 0, 0}, 0},
    {"mixamorig:LeftArm", 1, {18, 143, 0}, {0, 0, -kPi / 2}, 0.9},
    {"mixamorig:LeftForeArm", 5, {46, 143, 0}, {0, 0, -kPi / 2}, 1.2},
    {"mixamorig:LeftHand", 6, {72, 143, 0}, {0, 0, -kPi / 2}, 0.5},
    {"mixamorig:RightArm", 1, {-18, 143, 0}, {0, 0, kPi / 2}, 0.9},
    {"mixamorig:RightForeArm", 8, {-46, 143, 0}, {0, 0, kPi / 2}, 1.2},
    {"mixamorig:RightHand", 9, {-72, 143, 0}, {0, 0, kPi / 2}, 0.5},
    {"mixamorig:LeftUpLeg", 0, {9, 94, 0}, {0, 0, kPi}, 0.7},
    {"mixamorig:LeftLeg", 11, {9, 52, 0}, {0, 0, kPi}, 1.0},
    {"mixamorig:LeftFoot", 12, {9, 9, -2}, {kPi / 3, 0, 0}, 0.4},
    {"mixamorig:LeftToeBase", 13, {9, 2, 10}, {kPi / 2, 0, 0}, 0},
    {"mixamorig:RightUpLeg", 0, {-9, 94, 0}, {0, 0, kPi}, 0.7},
    {"mixamorig:RightLeg", 15, {-9, 52, 0}, {0, 0, kPi}, 1.0},
    {"mixamorig:RightFoot", 16, {-9, 9, -2}, {kPi / 3, 0, 0}, 0.4},
    {"mixamorig:RightToeBase", 17, {-9, 2, 10}, {kPi / 2, 0, 0}, 0},
};
constexpr int kCount = static_cast<int>(std::size(kJoints));

// From y up to the wanted axis up, by a cyclic change.
Quaterniond Turn(int up_axis) {
  return Quaterniond(
      AngleAxisd(2 * kPi / 3 * (up_axis - 1), Vector3d(1, 1, 1).normalized()));
}

Affine3d RestOf(int joint, const MadeFbxOptions& options) {
  const Quaterniond turn = Turn(options.up_axis);
  const Vector3d frame(kJoints[joint].frame);
  Affine3d rest = Affine3d::Identity();
  rest.translation() =
      turn * Vector3d(kJoints[joint].place) / options.centimetres_per_unit;
  rest.linear() =
      (turn * AngleAxisd(frame.norm(), frame.norm() > 0 ? frame.normalized()
                                                        : Vector3d::UnitX()))
          .toRotationMatrix();
  return rest;
}

// In the parent, at a frame of the animation.
Affine3d LocalOf(int joint, const Affine3d& rest, int frame,
                 const MadeFbxOptions& options) {
  const double phase = 2 * kPi * frame / options.frames + joint;
  const Vector3d axis =
      Vector3d(std::sin(joint + 1.0), std::cos(2.0 * joint), 0.5).normalized();
  Affine3d local =
      rest * AngleAxisd(kJoints[joint].swing * std::sin(phase), axis);
  if (joint == 0) {
    local.translation() += Turn(options.up_axis) *
                           Vector3d(frame, 3 * std::cos(phase), 2 * frame) /
                           options.centimetres_per_unit;
  }
  return local;
}

aiMatrix4x4 ToAssimp(const Affine3d& transform) {
  const Eigen::Matrix4f m = transform.matrix().cast<float>();
  return {m(0, 0), m(0, 1), m(0, 2), m(0, 3), m(1, 0), m(1, 1),
          m(1, 2), m(1, 3), m(2, 0), m(2, 1), m(2, 2), m(2, 3),
          m(3, 0), m(3, 1), m(3, 2), m(3, 3)};
}

class SceneMaker {
 public:
  explicit SceneMaker(const MadeFbxOptions& options) : options_(options) {
    for (int i = 0; i < kCount; ++i) {
      const int parent = kJoints[i].parent;
      rest_.push_back(RestOf(i, options));
      local_.push_back(parent < 0 ? rest_[i]
                                  : rest_[parent].inverse() * rest_[i]);
    }
  }

  MadeFbx Make() {
    auto scene = std::make_unique<aiScene>();
    scene->mMetaData = new aiMetadata();
    scene->mMetaData->Add("UnitScaleFactor", options_.centimetres_per_unit);
    scene->mMetaData->Add("UpAxis", static_cast<int32_t>(options_.up_axis));
    AddNodes(scene.get());
    AddAnimation(scene.get());
    MadeFbx made;
    made.bytes = Export(*scene);
    made.rest = rest_;
    made.frames_per_second = options_.frames_per_second;
    for (const Joint& joint : kJoints) {
      made.joints.push_back(joint.name);
      made.parents.push_back(joint.parent);
    }
    for (int frame = 0; frame < options_.frames; ++frame) {
      made.world.push_back(WorldAt(frame));
    }
    return made;
  }

 private:
  // As text: what the exporter of this version (5.2.5) writes in binary no
  // reader takes, its own neither. It rounds the times of keys to whole
  // seconds: keys are a second apart for it, and their times divided
  // afterwards.
  std::string Export(const aiScene& scene) const {
    Assimp::Exporter exporter;
    const aiExportDataBlob* blob = exporter.ExportToBlob(&scene, "fbxa");
    SINEW_CHECK(blob != nullptr) << exporter.GetErrorString();
    return WithKeyTimes(
        std::string(static_cast<const char*>(blob->data), blob->size));
  }

  std::string WithKeyTimes(const std::string& text) const {
    std::vector<std::string> lines = absl::StrSplit(text, '\n');
    for (size_t i = 1; i < lines.size(); ++i) {
      if (!absl::StrContains(lines[i - 1], "KeyTime:")) continue;
      const size_t start = lines[i].find("a: ") + 3;
      std::vector<std::string> times;
      for (const absl::string_view word :
           absl::StrSplit(absl::string_view(lines[i]).substr(start), ',')) {
        double time = 0;
        SINEW_CHECK(absl::SimpleAtod(word, &time)) << word;
        times.push_back(
            absl::StrCat(std::llround(time / options_.frames_per_second)));
      }
      lines[i] =
          absl::StrCat(lines[i].substr(0, start), absl::StrJoin(times, ","));
    }
    return absl::StrJoin(lines, "\n");
  }

  Affine3d Local(int joint, int frame) const {
    return LocalOf(joint, local_[joint], frame, options_);
  }

  std::vector<Affine3d> WorldAt(int frame) const {
    std::vector<Affine3d> world;
    for (int i = 0; i < kCount; ++i) {
      const int parent = kJoints[i].parent;
      world.push_back(parent < 0 ? Local(i, frame)
                                 : world[parent] * Local(i, frame));
    }
    return world;
  }

  void AddNodes(aiScene* scene) {
    scene->mRootNode = new aiNode("RootNode");
    std::vector<aiNode*> nodes;
    for (int i = 0; i < kCount; ++i) {
      auto* node = new aiNode(kJoints[i].name);
      node->mTransformation = ToAssimp(local_[i]);
      aiNode* parent =
          kJoints[i].parent < 0 ? scene->mRootNode : nodes[kJoints[i].parent];
      parent->addChildren(1, &node);
      nodes.push_back(node);
    }
    if (options_.mesh) AddMesh(scene);
  }

  // A triangle that every joint holds a little.
  void AddMesh(aiScene* scene) {
    auto* mesh = new aiMesh();
    mesh->mName = "Body";
    mesh->mPrimitiveTypes = aiPrimitiveType_TRIANGLE;
    mesh->mNumVertices = 3;
    mesh->mVertices = new aiVector3D[3]{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh->mNumFaces = 1;
    mesh->mFaces = new aiFace[1];
    mesh->mFaces[0].mNumIndices = 3;
    mesh->mFaces[0].mIndices = new unsigned[3]{0, 1, 2};
    mesh->mNumBones = kCount;
    mesh->mBones = new aiBone*[kCount];
    for (int i = 0; i < kCount; ++i) {
      auto* bone = new aiBone();
      bone->mName = kJoints[i].name;
      bone->mOffsetMatrix = ToAssimp(rest_[i].inverse());
      bone->mNumWeights = 3;
      bone->mWeights = new aiVertexWeight[3]{
          {0, 1.0f / kCount}, {1, 1.0f / kCount}, {2, 1.0f / kCount}};
      mesh->mBones[i] = bone;
    }
    scene->mNumMeshes = 1;
    scene->mMeshes = new aiMesh*[1]{mesh};
    scene->mNumMaterials = 1;
    scene->mMaterials = new aiMaterial*[1]{new aiMaterial()};
    auto* node = new aiNode("Body");
    node->mNumMeshes = 1;
    node->mMeshes = new unsigned[1]{0};
    scene->mRootNode->addChildren(1, &node);
  }

  void AddAnimation(aiScene* scene) {
    auto* animation = new aiAnimation();
    animation->mName = "mixamo.com";
    animation->mTicksPerSecond = 1;
    animation->mDuration = options_.frames - 1;
    animation->mNumChannels = kCount;
    animation->mChannels = new aiNodeAnim*[kCount];
    for (int i = 0; i < kCount; ++i) animation->mChannels[i] = Channel(i);
    scene->mNumAnimations = 1;
    scene->mAnimations = new aiAnimation*[1]{animation};
  }

  aiNodeAnim* Channel(int joint) const {
    const int frames = options_.frames;
    auto* channel = new aiNodeAnim();
    channel->mNodeName = kJoints[joint].name;
    channel->mNumPositionKeys = frames;
    channel->mNumRotationKeys = frames;
    channel->mNumScalingKeys = frames;
    channel->mPositionKeys = new aiVectorKey[frames];
    channel->mRotationKeys = new aiQuatKey[frames];
    channel->mScalingKeys = new aiVectorKey[frames];
    for (int frame = 0; frame < frames; ++frame) {
      const Affine3d local = Local(joint, frame);
      const Eigen::Vector3f place = local.translation().cast<float>();
      const Eigen::Quaternionf turn = Quaterniond(local.linear()).cast<float>();
      channel->mPositionKeys[frame] = {static_cast<double>(frame),
                                       {place.x(), place.y(), place.z()}};
      channel->mRotationKeys[frame] = {
          static_cast<double>(frame), {turn.w(), turn.x(), turn.y(), turn.z()}};
      channel->mScalingKeys[frame] = {static_cast<double>(frame), {1, 1, 1}};
    }
    return channel;
  }

  const MadeFbxOptions options_;
  std::vector<Affine3d> rest_;   // world
  std::vector<Affine3d> local_;  // in the parent, at rest
};

}  // namespace

MadeFbx MakeFbx(const MadeFbxOptions& options) {
  return SceneMaker(options).Make();
}

}  // namespace sinew::import::testing
