#include "sim/import/formats/fbx_clip.h"

#include <assimp/BaseImporter.h>
#include <assimp/config.h>
#include <assimp/importerdesc.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/status_macros.h"
#include "sim/import/formats/fbx_animation.h"
#include "sim/import/formats/fbx_limits.h"
#include "sim/import/formats/fbx_skeleton.h"
#include "sim/import/formats/file_frame.h"
#include "sim/import/formats/text_lines.h"
#include "sim/import/formats/unique_names.h"

namespace sinew::import {
namespace {

using Eigen::Affine3d;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kDefaultRate = 30;
// Keys so sparse say nothing of the rate.
constexpr double kLeastKeyRate = 10;
// How far a joint may move along its parent without a word, share of its
// distance from it.
constexpr double kStretch = 0.05;
// Half angles (rad) below it are rounding, not turns.
constexpr double kTurns = 1e-3;
// Frames a second of FBX's time modes; 0: it does not say.
constexpr double kModeRates[] = {0,
                                 120,
                                 100,
                                 60,
                                 50,
                                 48,
                                 30,
                                 30,
                                 30000.0 / 1001,
                                 30000.0 / 1001,
                                 25,
                                 24,
                                 1000,
                                 24000.0 / 1001};
constexpr int kCustomMode = 14;

// A number of the file's global settings.
std::optional<double> Setting(const aiScene& scene, const char* key) {
  if (scene.mMetaData == nullptr) return std::nullopt;
  int32_t whole;
  double real;
  float single;
  if (scene.mMetaData->Get(key, whole)) return whole;
  if (scene.mMetaData->Get(key, real)) return real;
  if (scene.mMetaData->Get(key, single)) return single;
  return std::nullopt;
}

double StatedRate(const aiScene& scene) {
  const double mode = Setting(scene, "FrameRate").value_or(0);
  if (mode == kCustomMode) {
    const double custom = Setting(scene, "CustomFrameRate").value_or(0);
    return custom >= kMinFramesPerSecond && custom <= kMaxFramesPerSecond
               ? custom
               : 0;
  }
  if (!(mode >= 0 && mode < static_cast<double>(std::size(kModeRates)))) {
    return 0;
  }
  return kModeRates[static_cast<int>(mode)];
}

// The rate, as given, as stated, or as its keys are spaced; says in `facts`
// which.
double ChooseRate(const aiScene& scene, const FbxAnimation& animation,
                  const ReadOptions& options, v1::ClipSource* facts) {
  if (options.frames_per_second.has_value()) return *options.frames_per_second;
  const double stated = StatedRate(scene);
  const double keys = animation.keys_per_second();
  if (stated > 0 && keys <= 1.01 * stated) return stated;
  facts->add_concluded("frames_per_second");
  if (keys < kLeastKeyRate || keys > kMaxFramesPerSecond) return kDefaultRate;
  return RateOfFrameTime(1 / keys);
}

FileFrame FrameOf(const aiScene& scene) {
  FileFrame frame;
  const double centimetres = Setting(scene, "UnitScaleFactor").value_or(0);
  if (centimetres > 1e-4 && centimetres < 1e5) {
    frame.metres_per_unit = 0.01 * centimetres;
  }
  const double axis = Setting(scene, "UpAxis").value_or(-1);
  const bool is_positive = Setting(scene, "UpAxisSign").value_or(1) > 0;
  if (is_positive && axis >= 0 && axis <= 2) {
    frame.up_axis = "xyz"[static_cast<int>(axis)];
  }
  return frame;
}

// The turn in a transform, scales left out; unset if it mirrors or flattens.
std::optional<Quaterniond> TurnOf(const Affine3d& transform) {
  Matrix3d linear = transform.linear();
  for (int i = 0; i < 3; ++i) {
    const double norm = linear.col(i).norm();
    if (!(norm > 1e-9)) return std::nullopt;
    linear.col(i) /= norm;
  }
  if (!(linear.determinant() > 0.1)) return std::nullopt;
  return Quaterniond(Affine3d(linear).rotation()).normalized();
}

// World transforms of the joints at rest.
std::vector<Affine3d> RestPose(const FbxAnimation& animation,
                               const FbxSkeleton& skeleton) {
  const std::vector<Affine3d> still = animation.Still();
  std::vector<Affine3d> rest;
  for (size_t i = 0; i < skeleton.nodes.size(); ++i) {
    const int node = skeleton.nodes[i];
    const int parent = skeleton.parents[i];
    if (animation.nodes()[node].bind.has_value()) {
      rest.push_back(*animation.nodes()[node].bind);
    } else if (parent < 0) {
      rest.push_back(still[node]);
    } else {
      rest.push_back(rest[parent] * still[skeleton.nodes[parent]].inverse() *
                     still[node]);
    }
  }
  return rest;
}

absl::Status JointError(absl::string_view source, const SourceJoint& joint,
                        absl::string_view what) {
  return absl::InvalidArgumentError(
      absl::StrCat(source, ": joint ", Quoted(joint.name), ": ", what));
}

// Builds the clip in the file's axes and units.
class ClipBuilder {
 public:
  ClipBuilder(const FbxAnimation& animation, const FbxSkeleton& skeleton,
              absl::string_view source, SourceClip* clip)
      : animation_(animation),
        skeleton_(skeleton),
        source_(source),
        rest_(RestPose(animation, skeleton)),
        stretch_(skeleton.nodes.size(), 0),
        turns_(skeleton.nodes.size(), false),
        clip_(clip) {}

  absl::Status AddSkeleton() {
    UniqueNames names;
    for (size_t i = 0; i < skeleton_.nodes.size(); ++i) {
      const FbxNode& node = animation_.nodes()[skeleton_.nodes[i]];
      const int parent = skeleton_.parents[i];
      SourceJoint joint{.name = names.Take(node.name),
                        .parent = parent,
                        .offset = Vector3d::Zero()};
      if (parent >= 0) {
        joint.offset = rest_[i].translation() - rest_[parent].translation();
      }
      const auto turn = TurnOf(rest_[i]);
      if (!turn.has_value() || !joint.offset.allFinite()) {
        return JointError(source_, joint,
                          "expected a rest pose that neither mirrors nor "
                          "flattens it");
      }
      rest_turn_.push_back(*turn);
      clip_->skeleton.joints.push_back(std::move(joint));
    }
    return absl::OkStatus();
  }

  absl::Status AddPoses(double rate) {
    const int64_t frames =
        static_cast<int64_t>(animation_.seconds() * rate + 1e-3) + 1;
    for (int64_t frame = 0; frame < frames; ++frame) {
      SINEW_RETURN_IF_ERROR(AddPose(static_cast<double>(frame) / rate));
    }
    return absl::OkStatus();
  }

  // What only the whole animation shows: ends, and joints that moved.
  void Finish() {
    std::vector<SourceJoint>& joints = clip_->skeleton.joints;
    for (size_t i = 1; i < joints.size(); ++i) joints[i].is_end = !turns_[i];
    for (size_t i = 1; i < joints.size(); ++i) {
      joints[joints[i].parent].is_end = false;
      if (stretch_[i] <= kStretch) continue;
      clip_->warnings.push_back(absl::StrFormat(
          "joint %s moves along its parent by up to %.0f %% of their "
          "distance; it is read as fixed",
          Quoted(joints[i].name), 100 * stretch_[i]));
    }
  }

 private:
  absl::Status AddPose(double time) {
    const std::vector<Affine3d> world = animation_.At(time);
    const std::vector<SourceJoint>& joints = clip_->skeleton.joints;
    SourcePose pose;
    pose.root_position = world[skeleton_.nodes[0]].translation();
    std::vector<Quaterniond> turned;  // from rest, in the world
    for (size_t i = 0; i < joints.size(); ++i) {
      const Affine3d& transform = world[skeleton_.nodes[i]];
      const auto turn = TurnOf(transform);
      if (!turn.has_value() || !transform.matrix().allFinite()) {
        return JointError(
            source_, joints[i],
            absl::StrFormat("at %.3f s: expected a pose that neither mirrors "
                            "nor flattens it",
                            time));
      }
      turned.push_back(*turn * rest_turn_[i].conjugate());
      const int parent = joints[i].parent;
      if (parent < 0) {
        pose.rotation.push_back(turned[i].normalized());
        continue;
      }
      pose.rotation.push_back(
          (turned[parent].conjugate() * turned[i]).normalized());
      turns_[i] = turns_[i] || pose.rotation[i].vec().norm() > kTurns;
      const Vector3d place = transform.translation() -
                             world[skeleton_.nodes[parent]].translation();
      const double distance = joints[i].offset.norm();
      if (distance > 0) {
        stretch_[i] = std::max(
            stretch_[i],
            (place - turned[parent] * joints[i].offset).norm() / distance);
      }
    }
    clip_->poses.push_back(std::move(pose));
    return absl::OkStatus();
  }

  const FbxAnimation& animation_;
  const FbxSkeleton& skeleton_;
  const absl::string_view source_;
  const std::vector<Affine3d> rest_;
  std::vector<Quaterniond> rest_turn_;
  std::vector<double> stretch_;
  std::vector<bool> turns_;
  SourceClip* const clip_;
};

// Leaves the library no format but FBX, whatever the bytes look like.
void KeepFbxOnly(Assimp::Importer* importer) {
  std::vector<std::unique_ptr<Assimp::BaseImporter>> others;
  for (size_t i = 0; i < importer->GetImporterCount(); ++i) {
    const aiImporterDesc* description = importer->GetImporterInfo(i);
    if (description != nullptr &&
        absl::StrContains(description->mFileExtensions, "fbx")) {
      continue;
    }
    others.emplace_back(importer->GetImporter(i));
  }
  for (const auto& other : others) importer->UnregisterLoader(other.get());
}

// The file as the library reads it. May throw.
const aiScene* ReadScene(absl::string_view bytes, Assimp::Importer* importer) {
  KeepFbxOnly(importer);
  importer->SetPropertyBool(AI_CONFIG_IMPORT_FBX_PRESERVE_PIVOTS, true);
  importer->SetPropertyBool(AI_CONFIG_IMPORT_FBX_READ_MATERIALS, false);
  importer->SetPropertyBool(AI_CONFIG_IMPORT_FBX_READ_TEXTURES, false);
  importer->SetPropertyBool(AI_CONFIG_IMPORT_FBX_READ_CAMERAS, false);
  importer->SetPropertyBool(AI_CONFIG_IMPORT_FBX_READ_LIGHTS, false);
  return importer->ReadFileFromMemory(bytes.data(), bytes.size(), 0, "fbx");
}

absl::Status CheckSize(const FbxAnimation& animation,
                       const FbxSkeleton& skeleton, double rate,
                       absl::string_view source) {
  if (!(animation.seconds() <= kMaxClipSeconds)) {
    return absl::ResourceExhaustedError(
        absl::StrCat(source, ": expected at most ", kMaxClipSeconds,
                     " seconds, found ", animation.seconds()));
  }
  const double rotations = (animation.seconds() * rate + 1) *
                           static_cast<double>(skeleton.nodes.size());
  if (rotations <= static_cast<double>(kFbxMaxRotations)) {
    return absl::OkStatus();
  }
  return absl::ResourceExhaustedError(absl::StrFormat(
      "%s: expected at most %d rotations, found %d joints for %g s at %g "
      "frames a second",
      source, kFbxMaxRotations, skeleton.nodes.size(), animation.seconds(),
      rate));
}

absl::StatusOr<SourceClip> BuildClip(const aiScene& scene,
                                     absl::string_view source,
                                     const ReadOptions& options) {
  SourceClip clip;
  SINEW_ASSIGN_OR_RETURN(const FbxAnimation animation,
                         FbxAnimation::Create(scene, source, &clip.warnings));
  SINEW_ASSIGN_OR_RETURN(const FbxSkeleton skeleton,
                         FindFbxSkeleton(animation, source));
  const double rate = ChooseRate(scene, animation, options, &clip.facts);
  SINEW_RETURN_IF_ERROR(CheckSize(animation, skeleton, rate, source));
  ClipBuilder builder(animation, skeleton, source, &clip);
  SINEW_RETURN_IF_ERROR(builder.AddSkeleton());
  SINEW_RETURN_IF_ERROR(builder.AddPoses(rate));
  builder.Finish();
  clip.facts.set_format("fbx");
  SINEW_RETURN_IF_ERROR(SetTimes(rate, source, clip));
  MoveToWorld(FrameOf(scene), options, clip);
  return clip;
}

}  // namespace

absl::StatusOr<SourceClip> ReadFbxHere(absl::string_view bytes,
                                       absl::string_view source,
                                       const ReadOptions& options) {
  // The library throws, also while it goes.
  try {
    Assimp::Importer importer;
    const aiScene* scene = ReadScene(bytes, &importer);
    if (scene == nullptr) {
      return absl::InvalidArgumentError(absl::StrCat(
          source, ": expected an FBX file, found: ",
          absl::CHexEscape(
              absl::string_view(importer.GetErrorString()).substr(0, 300))));
    }
    return BuildClip(*scene, source, options);
  } catch (const std::bad_alloc&) {
    return absl::ResourceExhaustedError(
        absl::StrCat(source,
                     ": expected a file of reasonable size, found one "
                     "that asks for more memory than is allowed"));
  } catch (const std::exception& error) {
    return absl::InvalidArgumentError(absl::StrCat(
        source, ": expected an FBX file, found: ",
        absl::CHexEscape(absl::string_view(error.what()).substr(0, 300))));
  }
}

}  // namespace sinew::import
