#ifndef SINEW_SIM_IMPORT_FORMATS_KEYFRAMES_H_
#define SINEW_SIM_IMPORT_FORMATS_KEYFRAMES_H_

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "sim/import/formats/source_clip.h"

namespace sinew::import {

// Motions as the keyframes of a MuJoCo model file (MJCF): a <keyframe> section
// with a <key> a frame. The XML is read as such, never by MuJoCo's compiler,
// whose trust in its input a stranger's file does not deserve.
//
// Times: the keys' `time`, each at least 0.1 ms past the one before; if no key
// says one, the given rate, else kDefaultKeyRate, which is then "concluded" in
// the facts.

inline constexpr double kDefaultKeyRate = 30;
// Larger files are refused.
inline constexpr int64_t kKeyframesMaxBytes = int64_t{128} << 20;

// Reads keys with `qpos` of a model in the same file, which has one free joint,
// first, and hinges: a robot's clip. Total: any bytes give a clip or an error
// that names `source`, key and attribute, expected and found. INVALID_ARGUMENT:
// not XML, no keys, fewer than two, keys without qpos (of mocap markers: see
// ParseMarkerKeyframes), qpos of other size than the model's, numbers that are
// none or not finite, times that do not rise so; a model with unnamed or other
// joints, or that this file does not hold whole (include, attach, replicate,
// composite, flexcomp); unit or up axis other than MuJoCo's.
// RESOURCE_EXHAUSTED: too large or too long.
absl::StatusOr<RobotClip> ParseKeyframes(absl::string_view bytes,
                                         absl::string_view name,
                                         absl::string_view source,
                                         const ReadOptions& options);

// Positions of markers on a body: no clip, since nothing says how the body is
// turned. No motion is imported from them, and only tests read them: they are
// recordings to measure retargeted clips of the same motions against.
struct MarkerClip {
  std::string name;
  std::vector<std::string> markers;
  // At least two, strictly rising from 0, s.
  std::vector<double> times;
  // [frames][markers], world, m, z up.
  std::vector<std::vector<Eigen::Vector3d>> positions;
  v1::ClipSource facts;
};

// Reads keys with `mpos`, the positions of mocap bodies. Markers are named
// after the model's mocap bodies, if it is in the file; 16 without a model are
// those of MuJoCo MPC's humanoid tracking: pelvis, head, ltoe, rtoe, lheel,
// rheel, lknee, rknee, lhand, rhand, lelbow, relbow, lshoulder, rshoulder,
// lhip, rhip; others are marker_0, marker_1 ... Errors: as ParseKeyframes.
absl::StatusOr<MarkerClip> ParseMarkerKeyframes(absl::string_view bytes,
                                                absl::string_view name,
                                                absl::string_view source,
                                                const ReadOptions& options);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_KEYFRAMES_H_
