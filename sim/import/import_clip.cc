#include "sim/import/import_clip.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/status_macros.h"
#include "sim/import/apply_edits.h"
#include "sim/import/clip_frames.h"
#include "sim/import/retarget/dynamics.h"
#include "sim/import/retarget/retarget.h"

namespace sinew::import {
namespace {

absl::Status CheckDuration(const std::string& name, double duration) {
  if (duration <= kMaxClipSeconds) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("clip ", name, ": expected at most ", kMaxClipSeconds,
                   " seconds, found ", duration));
}

SourcePreview MakePreview(const Retargeted& played) {
  SourcePreview preview;
  const double rate = played.motion.rate;
  const auto step =
      static_cast<size_t>(std::max(1.0, std::round(rate / kPreviewRate)));
  preview.frames_per_second = rate / static_cast<double>(step);
  preview.parents = played.source_parents;
  const auto frames =
      std::min(played.source_joints.size(),
               static_cast<size_t>(std::lround(kPreviewSeconds * rate)) + 1);
  for (size_t t = 0; t < frames; t += step) {
    for (const Eigen::Vector3d& position : played.source_joints[t]) {
      for (int i = 0; i < 3; ++i) {
        preview.positions.push_back(static_cast<float>(position[i]));
      }
    }
  }
  if (preview.positions.empty()) preview.parents.clear();
  return preview;
}

void FillInfo(const Retargeted& played, const std::string& name,
              const v1::ClipSource& facts, v1::ClipInfo* info) {
  const ModelMotion& motion = played.motion;
  info->set_name(name);
  info->set_num_frames(motion.frames());
  info->set_loops(motion.loops);
  info->set_cycle_x(motion.cycle.x);
  info->set_cycle_y(motion.cycle.y);
  info->set_cycle_yaw(motion.cycle.yaw);
  *info->mutable_quality() = played.quality;
  *info->mutable_source() = facts;
  if (!played.map.empty()) info->mutable_source()->set_map(played.map);
}

template <typename Clip>
absl::StatusOr<ImportedClip> Finish(const ImportModel& model, const Clip& clip,
                                    const ClipOptions& options,
                                    Retargeted played) {
  ImportedClip imported;
  Dynamics dynamics(model);
  if (HasEdits(options.edits)) {
    SINEW_RETURN_IF_ERROR(
        ApplyEdits(*options.mirror, options.edits, &dynamics, &played));
  }
  imported.frames = MakeClipFrames(&dynamics, played.motion, played.frames);
  FillInfo(played, clip.name, clip.facts, &imported.info);
  imported.preview = MakePreview(played);
  imported.duration_s = played.motion.frames() / played.motion.rate;
  imported.retiming = played.retiming;
  imported.supported_share = played.supported_share;
  imported.warnings = std::move(played.warnings);
  return imported;
}

}  // namespace

absl::StatusOr<ImportedClip> ImportClip(const ImportModel& model,
                                        const Source& source,
                                        const ClipOptions& options) {
  RetargetOptions retarget;
  retarget.rate = options.rate;
  retarget.map = options.map;
  if (const auto* clip = std::get_if<SourceClip>(&source)) {
    SINEW_RETURN_IF_ERROR(CheckDuration(clip->name, clip->duration()));
    SINEW_ASSIGN_OR_RETURN(Retargeted played,
                           RetargetClip(model, *clip, retarget));
    return Finish(model, *clip, options, std::move(played));
  }
  const auto& clip = std::get<RobotClip>(source);
  SINEW_RETURN_IF_ERROR(CheckDuration(clip.name, clip.duration()));
  SINEW_ASSIGN_OR_RETURN(Retargeted played,
                         FitRobotClip(model, clip, retarget));
  return Finish(model, clip, options, std::move(played));
}

}  // namespace sinew::import
