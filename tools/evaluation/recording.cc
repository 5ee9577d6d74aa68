#include "tools/evaluation/recording.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "common/status_macros.h"
#include "sim/character/model_ptr.h"
#include "sim/world/tracking_task.h"
#include "tools/evaluation/rollout_pool.h"

namespace sinew::evaluation {

std::vector<double> ReferencePoses(const character::Character& character,
                                   const motion::Library& library, int clip,
                                   int first, int frames) {
  const mjModel* model = character.model();
  const character::DataPtr data(mj_makeData(model));
  motion::ReferenceFrame reference(library);
  std::vector<double> poses;
  poses.reserve(static_cast<size_t>(frames) * model->nq);
  for (int frame = 0; frame < frames; ++frame) {
    reference.Load(clip, first + frame);
    world::SetReferencePose(character, reference.view(), data.get());
    poses.insert(poses.end(), data->qpos, data->qpos + model->nq);
  }
  return poses;
}

int FramesToShow(const motion::Library& library, int clip, double seconds) {
  const double asked =
      std::round(seconds * library.manifest().frames_per_second()) + 1;
  const v1::ClipInfo& info = library.clip(clip);
  const auto most =
      info.loops() ? asked
                   : std::min(asked, static_cast<double>(info.num_frames()));
  return static_cast<int>(std::clamp(most, 2.0, 1e6));
}

absl::StatusOr<Recording> RecordClip(const Subject& subject, int clip,
                                     double seconds, const StopToken& stop) {
  if (!(seconds > 0)) {
    return absl::InvalidArgumentError(
        absl::StrCat("seconds: expected > 0, found ", seconds));
  }
  const int frames = FramesToShow(subject.library(), clip, seconds);
  Recording recording;
  recording.nq = subject.character().model()->nq;
  recording.frames_per_second =
      subject.library().manifest().frames_per_second();
  recording.simulated = ReferencePoses(subject.character(), subject.library(),
                                       clip, /*first=*/0, /*frames=*/1);
  v1::EvaluationStart start;
  start.set_clip(clip);
  start.set_steps(frames - 1);
  SINEW_ASSIGN_OR_RETURN(
      const std::vector<v1::EvaluationResult> results,
      RunStarts(subject.assets, *subject.policy, {start}, /*threads=*/1, stop,
                [&](size_t, int, const mjData& data, absl::Span<const float>) {
                  recording.simulated.insert(recording.simulated.end(),
                                             data.qpos,
                                             data.qpos + recording.nq);
                }));
  recording.survived = results.front().success();
  recording.reference =
      ReferencePoses(subject.character(), subject.library(), clip,
                     /*first=*/0, recording.frames());
  return recording;
}

}  // namespace sinew::evaluation
