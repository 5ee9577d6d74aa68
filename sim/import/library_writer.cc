#include "sim/import/library_writer.h"

#include "common/policy/safetensors.h"
#include "common/status_macros.h"
#include "sim/import/clip_frames.h"
#include "sim/motion/library.h"

namespace sinew::import {
namespace {

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

}  // namespace

absl::Status WriteLibrary(const character::Character& character,
                          const ImportModel& model, double rate,
                          absl::Span<const ClipReport> reports,
                          const ClipCache& cache,
                          const std::string& directory) {
  v1::MotionLibrary manifest = MakeManifest(character, model, rate);
  TensorMap frames;
  for (const ClipReport& report : reports) {
    if (!report.status.ok()) continue;
    SINEW_ASSIGN_OR_RETURN(const CachedClip clip, cache.Load(report.cache_key));
    AppendFrames(clip.frames, &frames);
    v1::ClipInfo* info = manifest.add_clips();
    *info = report.info;
    info->set_first_frame(manifest.num_frames());
    manifest.set_num_frames(manifest.num_frames() + info->num_frames());
  }
  return motion::Library::Save(manifest, frames, directory);
}

}  // namespace sinew::import
