#include "sim/import/importer.h"

#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "sim/import/clip_frames.h"
#include "sim/import/formats/deepmimic.h"
#include "sim/import/retarget/dynamics.h"
#include "sim/import/retarget/retarget.h"
#include "sim/motion/library.h"

namespace sinew::import {
namespace {

std::string BaseName(const std::string& path) {
  return path.substr(path.find_last_of('/') + 1);
}

std::string Stem(const std::string& path) {
  const std::string base = BaseName(path);
  const size_t dot = base.find_last_of('.');
  return dot == std::string::npos || dot == 0 ? base : base.substr(0, dot);
}

v1::MotionLibrary MakeManifest(const character::Character& character,
                               const ImportModel& model, double rate) {
  v1::MotionLibrary manifest;
  manifest.set_character(character.name());
  manifest.set_character_sha256(character.digest());
  manifest.set_frames_per_second(rate);
  for (const character::JointInfo& joint : character.joints()) {
    manifest.add_joints(joint.name);
  }
  for (int b = 1; b < model.model->nbody; ++b) {
    manifest.add_bodies(mj_id2name(model.model, mjOBJ_BODY, b));
  }
  for (const int foot : model.feet) {
    manifest.add_feet(mj_id2name(model.model, mjOBJ_BODY, foot));
  }
  return manifest;
}

absl::StatusOr<ImportedClip> ImportFile(const ImportModel& model,
                                        const std::string& file,
                                        const ImportOptions& options) {
  SINEW_ASSIGN_OR_RETURN(const std::string bytes,
                         ReadFile(file, kDeepMimicMaxBytes));
  SINEW_ASSIGN_OR_RETURN(const SourceClip clip,
                         ParseDeepMimic(bytes, Stem(file), file));
  SINEW_ASSIGN_OR_RETURN(ImportedClip imported,
                         ImportClip(model, clip, options));
  imported.report.info.set_source_file(BaseName(file));
  imported.report.info.set_source_sha256(Sha256Hex(bytes));
  return imported;
}

absl::Status CheckOptions(const ImportOptions& options) {
  if (options.rate > 0 && options.rate <= 1000) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      "rate: expected > 0 and at most 1000 frames per second, found ",
      options.rate));
}

}  // namespace

absl::StatusOr<ImportedClip> ImportClip(const ImportModel& model,
                                        const SourceClip& clip,
                                        const ImportOptions& options) {
  SINEW_RETURN_IF_ERROR(CheckOptions(options));
  RetargetOptions retarget;
  retarget.rate = options.rate;
  SINEW_ASSIGN_OR_RETURN(const Retargeted played,
                         RetargetClip(model, clip, retarget));
  const ModelMotion& motion = played.motion;
  Dynamics dynamics(model);
  ImportedClip imported;
  imported.frames = MakeClipFrames(&dynamics, motion, played.frames);
  ClipReport& report = imported.report;
  report.name = clip.name;
  report.duration_s = clip.duration();
  report.retiming = played.retiming;
  report.seam_max_rad = played.seam_max_rad;
  report.supported_share = played.supported_share;
  report.warnings = played.warnings;

  v1::ClipInfo& info = report.info;
  info.set_name(clip.name);
  info.set_num_frames(motion.frames());
  info.set_loops(motion.loops);
  info.set_cycle_x(motion.cycle.x);
  info.set_cycle_y(motion.cycle.y);
  info.set_cycle_yaw(motion.cycle.yaw);
  info.set_provenance(options.provenance);
  info.set_licence(options.licence);
  *info.mutable_quality() = played.quality;
  return imported;
}

absl::Status ImportFiles(const character::Character& character,
                         const std::vector<std::string>& files,
                         const ImportOptions& options,
                         const std::string& directory,
                         std::vector<ClipReport>* reports) {
  SINEW_RETURN_IF_ERROR(CheckOptions(options));
  const ImportModel model = MakeImportModel(character);
  v1::MotionLibrary manifest = MakeManifest(character, model, options.rate);
  TensorMap frames;
  std::set<std::string> names;
  for (const std::string& file : files) {
    ClipReport report;
    absl::StatusOr<ImportedClip> imported = ImportFile(model, file, options);
    if (imported.ok() && !names.insert(Stem(file)).second) {
      imported = absl::AlreadyExistsError(absl::StrCat(
          file, ": expected a unique name, found \"", Stem(file), "\" twice"));
    }
    if (imported.ok()) {
      report = std::move(imported->report);
      report.info.set_first_frame(manifest.num_frames());
      manifest.set_num_frames(manifest.num_frames() +
                              report.info.num_frames());
      *manifest.add_clips() = report.info;
      AppendFrames(imported->frames, &frames);
    } else {
      report.name = Stem(file);
    }
    report.file = file;
    report.status = imported.status();
    reports->push_back(std::move(report));
  }
  if (manifest.clips().empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("expected at least one clip that can be imported, found "
                     "none in ",
                     files.size(), " files"));
  }
  return motion::Library::Save(manifest, frames, directory);
}

}  // namespace sinew::import
