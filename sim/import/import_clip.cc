#include "sim/import/import_clip.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <variant>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
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

const std::string& NameOf(const Source& source) {
  return std::visit(
      [](const auto& clip) -> const std::string& { return clip.name; }, source);
}

const v1::ClipSource& FactsOf(const Source& source) {
  return std::visit(
      [](const auto& clip) -> const v1::ClipSource& { return clip.facts; },
      source);
}

// A clip as it is on the character, without edits.
absl::StatusOr<Retargeted> Play(const ImportModel& model, const Source& source,
                                const ClipOptions& options) {
  RetargetOptions retarget;
  retarget.rate = options.rate;
  retarget.map = options.map;
  retarget.stop = options.stop;
  if (const auto* clip = std::get_if<SourceClip>(&source)) {
    SINEW_RETURN_IF_ERROR(CheckDuration(clip->name, clip->duration()));
    return RetargetClip(model, *clip, retarget);
  }
  const auto& clip = std::get<RobotClip>(source);
  SINEW_RETURN_IF_ERROR(CheckDuration(clip.name, clip.duration()));
  return FitRobotClip(model, clip, retarget);
}

absl::StatusOr<ImportedClip> Finish(const Source& source,
                                    const ClipOptions& options,
                                    Retargeted played, Dynamics* dynamics) {
  ImportedClip imported;
  if (HasEdits(options.edits)) {
    SINEW_RETURN_IF_ERROR(
        ApplyEdits(*options.mirror, options.edits, dynamics, &played));
  }
  imported.frames = MakeClipFrames(dynamics, played.motion, played.frames);
  FillInfo(played, NameOf(source), FactsOf(source), &imported.info);
  imported.preview = MakePreview(played);
  imported.duration_s = played.motion.frames() / played.motion.rate;
  imported.retiming = played.retiming;
  imported.supported_share = played.supported_share;
  imported.warnings = std::move(played.warnings);
  return imported;
}

// Says which of two clips a warning is of. Not by name: the same content may
// have another one when it comes from the cache.
void MarkWarnings(absl::string_view which, Retargeted* played) {
  for (std::string& warning : played->warnings) {
    warning = absl::StrCat(which, " clip: ", warning);
  }
}

}  // namespace

absl::StatusOr<ImportedClip> ImportClip(const ImportModel& model,
                                        const Source& source,
                                        const ClipOptions& options) {
  SINEW_ASSIGN_OR_RETURN(Retargeted played, Play(model, source, options));
  Dynamics dynamics(model);
  return Finish(source, options, std::move(played), &dynamics);
}

absl::StatusOr<ImportedClip> ImportBlend(const ImportModel& model,
                                         const Source& first,
                                         const Source& second,
                                         const BlendOptions& blend,
                                         const ClipOptions& options) {
  SINEW_RETURN_IF_ERROR(CheckBlendOptions(blend));
  SINEW_ASSIGN_OR_RETURN(Retargeted before, Play(model, first, options));
  SINEW_ASSIGN_OR_RETURN(Retargeted after, Play(model, second, options));
  MarkWarnings("first", &before);
  MarkWarnings("second", &after);
  Dynamics dynamics(model);
  SINEW_ASSIGN_OR_RETURN(
      Retargeted blended,
      BlendClips(blend, before, after, &dynamics, options.stop));
  SINEW_RETURN_IF_ERROR(
      CheckDuration(absl::StrCat(NameOf(first), " + ", NameOf(second)),
                    blended.motion.frames() / blended.motion.rate));
  SINEW_ASSIGN_OR_RETURN(ImportedClip imported,
                         Finish(first, options, std::move(blended), &dynamics));
  v1::BlendedClip* next = imported.info.mutable_blend();
  *next->mutable_source() = FactsOf(second);
  if (!after.map.empty()) next->mutable_source()->set_map(after.map);
  next->set_gap_s(BlendSteps(blend.gap_s, options.rate) / options.rate);
  return imported;
}

}  // namespace sinew::import
