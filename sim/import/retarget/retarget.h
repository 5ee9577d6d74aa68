#ifndef SINEW_SIM_IMPORT_RETARGET_RETARGET_H_
#define SINEW_SIM_IMPORT_RETARGET_RETARGET_H_

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/stop.h"
#include "proto/sinew/v1/motion.pb.h"
#include "proto/sinew/v1/skeleton_map.pb.h"
#include "sim/import/formats/source_clip.h"
#include "sim/import/retarget/import_model.h"
#include "sim/import/retarget/model_motion.h"
#include "sim/import/retarget/quality.h"

namespace sinew::import {

// Name of maps that nobody has looked at.
inline constexpr char kDraftName[] = "draft";

struct RetargetOptions {
  // Frames per second of the motion, > 0 and at most 1000.
  double rate = 30;
  // Which joint of the source is what. Unset: found among the maps that come
  // with this project or, if none fits, drafted.
  const v1::SkeletonMap* map = nullptr;
  // Whether to change the motion so that forces explain it (RefineMotion).
  bool refine = true;
  StopToken stop = {};
};

// Frames that a motion may have: four hours at 30 frames per second.
inline constexpr int64_t kMaxFrames = 432000;

// A clip on a character.
struct Retargeted {
  ModelMotion motion;
  std::vector<FrameDynamics> frames;
  v1::ClipQuality quality;
  // Name of the skeleton map; of robot clips empty.
  std::string map;
  // Things worth a look, one sentence each; those of the source first.
  std::vector<std::string> warnings;
  // [frames][joints] the source's skeleton at the character's size, where the
  // motion has it; for pictures. Of robot clips empty.
  std::vector<std::vector<Eigen::Vector3d>> source_joints;
  std::vector<int> source_parents;  // [joints], -1: root
  // Speed against the source, from rounding to whole frames.
  double retiming = 1;
  // Frames that the floor carries, share of all.
  double supported_share = 0;
};

// Plays a clip on a character: joints, floor, forces, figures of quality.
//
// Thread-safety: any thread (all state is local). Ownership: borrows its
// arguments for the call. Blocking: seconds of computation per clip; reads the
// maps that come with the project unless options.map is set. Memory: about
// 4 kB a frame, and what is fitted at a time (170 MB for the humanoid, see
// PoseFitOptions). Errors:
// INVALID_ARGUMENT naming the map and what was expected of it, or what of the
// character does not fit (no hips, knees or ankles); RESOURCE_EXHAUSTED: more
// than kMaxFrames; CANCELLED: stopped, after the step that was
// running: seconds for clips of minutes.
absl::StatusOr<Retargeted> RetargetClip(const ImportModel& model,
                                        const SourceClip& clip,
                                        const RetargetOptions& options);

// The same for a clip in the coordinates of a robot: joints by name, those that
// the clip lacks at their default; the rest of `options.map` is not looked at.
// INVALID_ARGUMENT naming the clip if less than half of its joints are the
// character's.
absl::StatusOr<Retargeted> FitRobotClip(const ImportModel& model,
                                        const RobotClip& clip,
                                        const RetargetOptions& options);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_RETARGET_RETARGET_H_
