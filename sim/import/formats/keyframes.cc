#include "sim/import/formats/keyframes.h"

#include <tinyxml2.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/escaping.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "common/status_macros.h"
#include "sim/import/formats/file_frame.h"
#include "sim/import/formats/mjcf_joints.h"
#include "sim/import/formats/text_lines.h"

namespace sinew::import {
namespace {

using Eigen::Vector3d;
using tinyxml2::XMLElement;

// Beyond it numbers cannot be what they should: m, rad, s.
constexpr double kMaxNumber = 1e6;
constexpr int kRootNumbers = 7;  // position and quaternion

constexpr const char* kMjpcMarkers[] = {
    "pelvis",    "head",      "ltoe",  "rtoe",  "lheel",  "rheel",
    "lknee",     "rknee",     "lhand", "rhand", "lelbow", "relbow",
    "lshoulder", "rshoulder", "lhip",  "rhip"};

// The file, its keys, and what it says of a model.
struct KeyFile {
  std::string source;
  tinyxml2::XMLDocument document;
  MjcfJoints joints;
  std::vector<const XMLElement*> keys;
};

absl::Status KeyError(const KeyFile& file, size_t key,
                      absl::string_view attribute, absl::string_view what) {
  const char* name = file.keys[key]->Attribute("name");
  return absl::InvalidArgumentError(absl::StrCat(file.source, ": key ", key,
                                                 " (", Quoted(name ? name : ""),
                                                 "): ", attribute, ": ", what));
}

absl::Status FindKeys(const XMLElement& mujoco, KeyFile* file) {
  for (const XMLElement* section = mujoco.FirstChildElement("keyframe");
       section != nullptr; section = section->NextSiblingElement("keyframe")) {
    for (const XMLElement* key = section->FirstChildElement("key");
         key != nullptr; key = key->NextSiblingElement("key")) {
      file->keys.push_back(key);
    }
  }
  if (file->keys.size() >= 2) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(file->source, ": expected at least 2 keys in a <keyframe>, ",
                   "found ", file->keys.size()));
}

absl::StatusOr<std::unique_ptr<KeyFile>> ReadKeyFile(
    absl::string_view bytes, absl::string_view source,
    const ReadOptions& options) {
  SINEW_RETURN_IF_ERROR(CheckReadOptions(options));
  SINEW_RETURN_IF_ERROR(CheckFixedFrame(options, /*metres_per_unit=*/1,
                                        /*up_axis=*/'z', "MuJoCo", source));
  SINEW_RETURN_IF_ERROR(CheckFileSize(bytes, kKeyframesMaxBytes, source));
  auto file = std::make_unique<KeyFile>();
  file->source = std::string(source);
  tinyxml2::XMLDocument& document = file->document;
  if (document.Parse(bytes.data(), bytes.size()) != tinyxml2::XML_SUCCESS) {
    return absl::InvalidArgumentError(absl::StrCat(
        source,
        ": expected XML, found: ", absl::CHexEscape(document.ErrorStr())));
  }
  const XMLElement* root = document.RootElement();
  if (root == nullptr || absl::string_view(root->Name()) != "mujoco") {
    return absl::InvalidArgumentError(absl::StrCat(
        source, ": expected a <mujoco> element, found <",
        root ? absl::CHexEscape(root->Name()).substr(0, 60) : "none", ">"));
  }
  SINEW_RETURN_IF_ERROR(FindKeys(*root, file.get()));
  SINEW_ASSIGN_OR_RETURN(file->joints, ReadMjcfJoints(*root, source));
  return file;
}

bool HasAttribute(const KeyFile& file, size_t key, const char* attribute) {
  return file.keys[key]->Attribute(attribute) != nullptr;
}

absl::StatusOr<std::vector<double>> ReadNumbers(const KeyFile& file, size_t key,
                                                const char* attribute) {
  const char* text = file.keys[key]->Attribute(attribute);
  std::vector<double> numbers;
  for (const absl::string_view word :
       absl::StrSplit(absl::string_view(text ? text : ""),
                      absl::ByAnyChar(" \t\r\n"), absl::SkipEmpty())) {
    double value;
    if (!absl::SimpleAtod(word, &value) || !(std::abs(value) <= kMaxNumber)) {
      return KeyError(file, key, attribute,
                      absl::StrFormat("expected numbers within +-%g, found %s",
                                      kMaxNumber, Quoted(word)));
    }
    numbers.push_back(value);
  }
  return numbers;
}

absl::StatusOr<std::vector<double>> TimesAsWritten(const KeyFile& file) {
  std::vector<double> times;
  for (size_t key = 0; key < file.keys.size(); ++key) {
    SINEW_ASSIGN_OR_RETURN(const std::vector<double> time,
                           ReadNumbers(file, key, "time"));
    if (time.size() > 1) {
      return KeyError(file, key, "time", "expected one number");
    }
    times.push_back(time.empty() ? 0 : time[0]);
  }
  if (std::all_of(times.begin(), times.end(),
                  [](double time) { return time == 0; })) {
    return std::vector<double>();
  }
  for (size_t key = 1; key < times.size(); ++key) {
    // Times of an even rate are rounded as they are written.
    constexpr double kLeast = 0.99 / kMaxFramesPerSecond;
    if (times[key] - times[key - 1] >= kLeast) continue;
    return KeyError(file, key, "time",
                    absl::StrCat("expected at least ", 1 / kMaxFramesPerSecond,
                                 " s more than the ", times[key - 1],
                                 " s of the key before, found ", times[key]));
  }
  return times;
}

// Times from 0, and what the facts say of them.
absl::StatusOr<std::vector<double>> ReadTimes(const KeyFile& file,
                                              const ReadOptions& options,
                                              v1::ClipSource* facts) {
  std::vector<double> times;
  if (!options.frames_per_second.has_value()) {
    SINEW_ASSIGN_OR_RETURN(times, TimesAsWritten(file));
  }
  if (times.empty()) {
    const double rate = options.frames_per_second.value_or(kDefaultKeyRate);
    for (size_t key = 0; key < file.keys.size(); ++key) {
      times.push_back(static_cast<double>(key) / rate);
    }
    if (!options.frames_per_second.has_value()) {
      facts->add_concluded("frames_per_second");
    }
  }
  const double start = times[0];
  for (double& time : times) time -= start;
  if (times.back() > kMaxClipSeconds) {
    return absl::ResourceExhaustedError(
        absl::StrCat(file.source, ": expected at most ", kMaxClipSeconds,
                     " seconds, found ", times.back()));
  }
  facts->set_format("keyframes");
  facts->set_duration_s(times.back());
  facts->set_frames_per_second(static_cast<double>(times.size() - 1) /
                               times.back());
  facts->set_metres_per_unit(1);
  facts->set_up_axis("z");
  return times;
}

// A file whose every key has qpos, of the size that its model has.
absl::Status CheckIsRobot(const KeyFile& file) {
  for (size_t key = 0; key < file.keys.size(); ++key) {
    if (HasAttribute(file, key, "qpos")) continue;
    return KeyError(
        file, key, "qpos",
        HasAttribute(file, key, "mpos")
            ? "expected the model's coordinates, found mpos alone: positions "
              "of markers cannot be imported as a clip"
            : "expected the model's coordinates, found none");
  }
  if (!file.joints.has_free_joint || file.joints.hinges.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        file.source, ": expected a model with a free joint and hinges beside ",
        "the keys, found ",
        file.joints.empty()          ? "none"
        : file.joints.hinges.empty() ? "no hinges"
                                     : "no free joint"));
  }
  return absl::OkStatus();
}

absl::StatusOr<RobotPose> ReadPose(const KeyFile& file, size_t key) {
  SINEW_ASSIGN_OR_RETURN(const std::vector<double> qpos,
                         ReadNumbers(file, key, "qpos"));
  const size_t expected = kRootNumbers + file.joints.hinges.size();
  if (qpos.size() != expected) {
    return KeyError(
        file, key, "qpos",
        absl::StrCat("expected ", expected,
                     " numbers, as its model has, found ", qpos.size()));
  }
  RobotPose pose;
  pose.root_position = Vector3d(qpos[0], qpos[1], qpos[2]);
  const Eigen::Quaterniond rotation(qpos[3], qpos[4], qpos[5], qpos[6]);
  const double norm = rotation.norm();
  if (!(std::abs(norm - 1) <= kRobotNormTolerance)) {
    return KeyError(
        file, key, "qpos",
        absl::StrFormat("numbers 3 to 6: expected a unit quaternion (norm 1 "
                        "+- %g), found norm %g",
                        kRobotNormTolerance, norm));
  }
  pose.root_rotation = rotation.normalized();
  pose.joints = Eigen::Map<const Eigen::VectorXd>(qpos.data() + kRootNumbers,
                                                  qpos.size() - kRootNumbers);
  return pose;
}

// Names for so many markers.
absl::StatusOr<std::vector<std::string>> MarkerNames(const KeyFile& file,
                                                     size_t count) {
  const std::vector<std::string>& bodies = file.joints.mocap_bodies;
  if (!bodies.empty()) {
    if (bodies.size() == count) return bodies;
    return KeyError(file, 0, "mpos",
                    absl::StrCat("expected ", bodies.size(),
                                 " markers, as the model has mocap bodies, "
                                 "found ",
                                 count));
  }
  if (count == std::size(kMjpcMarkers)) {
    return std::vector<std::string>(std::begin(kMjpcMarkers),
                                    std::end(kMjpcMarkers));
  }
  std::vector<std::string> names;
  for (size_t i = 0; i < count; ++i)
    names.push_back(absl::StrCat("marker_", i));
  return names;
}

absl::StatusOr<std::vector<Vector3d>> ReadMarkers(const KeyFile& file,
                                                  size_t key) {
  SINEW_ASSIGN_OR_RETURN(const std::vector<double> mpos,
                         ReadNumbers(file, key, "mpos"));
  if (mpos.empty() || mpos.size() % 3 != 0) {
    return KeyError(
        file, key, "mpos",
        absl::StrCat("expected 3 numbers a marker, found ", mpos.size()));
  }
  std::vector<Vector3d> positions;
  for (size_t i = 0; i < mpos.size(); i += 3) {
    positions.emplace_back(mpos[i], mpos[i + 1], mpos[i + 2]);
  }
  return positions;
}

}  // namespace

absl::StatusOr<RobotClip> ParseKeyframes(absl::string_view bytes,
                                         absl::string_view name,
                                         absl::string_view source,
                                         const ReadOptions& options) {
  SINEW_ASSIGN_OR_RETURN(const std::unique_ptr<KeyFile> file,
                         ReadKeyFile(bytes, source, options));
  SINEW_RETURN_IF_ERROR(CheckIsRobot(*file));
  RobotClip clip;
  clip.name = std::string(name);
  clip.joints = file->joints.hinges;
  SINEW_ASSIGN_OR_RETURN(const std::vector<double> times,
                         ReadTimes(*file, options, &clip.facts));
  for (size_t key = 0; key < file->keys.size(); ++key) {
    SINEW_ASSIGN_OR_RETURN(RobotPose pose, ReadPose(*file, key));
    pose.time = times[key];
    clip.poses.push_back(std::move(pose));
  }
  if (clip.facts.concluded_size() > 0) {
    clip.warnings.push_back(
        absl::StrFormat("the keys say no times; read at %g frames per second, "
                        "the default",
                        kDefaultKeyRate));
  }
  return clip;
}

absl::StatusOr<MarkerClip> ParseMarkerKeyframes(absl::string_view bytes,
                                                absl::string_view name,
                                                absl::string_view source,
                                                const ReadOptions& options) {
  SINEW_ASSIGN_OR_RETURN(const std::unique_ptr<KeyFile> file,
                         ReadKeyFile(bytes, source, options));
  MarkerClip clip;
  clip.name = std::string(name);
  SINEW_ASSIGN_OR_RETURN(clip.times, ReadTimes(*file, options, &clip.facts));
  for (size_t key = 0; key < file->keys.size(); ++key) {
    SINEW_ASSIGN_OR_RETURN(std::vector<Vector3d> positions,
                           ReadMarkers(*file, key));
    if (key == 0) {
      SINEW_ASSIGN_OR_RETURN(clip.markers,
                             MarkerNames(*file, positions.size()));
    }
    if (positions.size() != clip.markers.size()) {
      return KeyError(
          *file, key, "mpos",
          absl::StrCat("expected ", clip.markers.size(),
                       " markers as in key 0, found ", positions.size()));
    }
    clip.positions.push_back(std::move(positions));
  }
  return clip;
}

}  // namespace sinew::import
