#include "tools/evaluation/recording.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "absl/strings/str_cat.h"
#include "actor/fallen_evaluation.h"
#include "common/status_macros.h"
#include "sim/character/model_ptr.h"
#include "sim/world/tracking_task.h"
#include "tools/evaluation/fallen_figures.h"
#include "tools/evaluation/rollout_pool.h"

namespace sinew::evaluation {
namespace {

Recording EmptyRecording(const Subject& subject) {
  Recording recording;
  recording.nq = subject.character().model()->nq;
  recording.frames_per_second =
      subject.library().manifest().frames_per_second();
  return recording;
}

// Runs one start, adding its poses to `recording`.
absl::StatusOr<v1::EvaluationResult> Run(const Subject& subject,
                                         const v1::EvaluationStart& start,
                                         const StopToken& stop,
                                         Recording* recording) {
  std::vector<double>& poses = recording->simulated;
  SINEW_ASSIGN_OR_RETURN(
      const std::vector<v1::EvaluationResult> results,
      RunStarts(subject.assets, *subject.policy, {start}, /*threads=*/1, stop,
                [&](size_t, int, const mjData& data, absl::Span<const float>) {
                  poses.insert(poses.end(), data.qpos,
                               data.qpos + recording->nq);
                }));
  recording->survived = results.front().success();
  return results.front();
}

// The pose in which a fallen body begins a start, [nq].
std::vector<double> FallenPose(const world::TrackingTask& task,
                               const v1::EvaluationStart& start) {
  const mjModel* model = task.character().model();
  const character::DataPtr data(mj_makeData(model));
  const auto work = task.MakeWorkspace();
  std::vector<double> target(task.action_width());
  world::Episode episode = {.clip = start.clip()};
  task.Begin(actor::BodyStartOf(start), /*noise=*/nullptr, data.get(), &episode,
             absl::MakeSpan(target), work.get());
  return {data->qpos, data->qpos + model->nq};
}

}  // namespace

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
  Recording recording = EmptyRecording(subject);
  recording.simulated = ReferencePoses(subject.character(), subject.library(),
                                       clip, /*first=*/0, /*frames=*/1);
  v1::EvaluationStart start;
  start.set_clip(clip);
  start.set_steps(frames - 1);
  SINEW_RETURN_IF_ERROR(Run(subject, start, stop, &recording).status());
  recording.reference =
      ReferencePoses(subject.character(), subject.library(), clip,
                     /*first=*/0, recording.frames());
  return recording;
}

absl::StatusOr<Recording> RecordFallen(const Subject& subject, int state,
                                       bool get_up, const StopToken& stop) {
  const world::TrackingTask& task = subject.assets->task();
  SINEW_ASSIGN_OR_RETURN(const std::vector<v1::EvaluationStart> starts,
                         get_up ? actor::GetUpStarts(task, kLateSeconds)
                                : actor::FallenStarts(task, kLateSeconds));
  if (state < 0 || state >= static_cast<int>(starts.size())) {
    return absl::InvalidArgumentError(absl::StrCat(
        "fallen state: expected 0 to ", starts.size() - 1, ", found ", state));
  }
  const v1::EvaluationStart& start = starts[state];
  Recording recording = EmptyRecording(subject);
  recording.simulated = FallenPose(task, start);
  SINEW_ASSIGN_OR_RETURN(const v1::EvaluationResult result,
                         Run(subject, start, stop, &recording));
  // What stands is the frame that the first step is compared with.
  const std::vector<double> clip =
      ReferencePoses(subject.character(), subject.library(), result.clip(),
                     result.start_frame(), recording.frames() + 1);
  for (int frame = 0; frame < recording.frames(); ++frame) {
    const int shown =
        frame == 0 ? 0 : std::max(1, frame - start.recovery_steps());
    const auto pose = clip.begin() + int64_t{shown} * recording.nq;
    recording.reference.insert(recording.reference.end(), pose,
                               pose + recording.nq);
  }
  return recording;
}

}  // namespace sinew::evaluation
