#include "tools/evaluation/recording.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "absl/strings/str_cat.h"
#include "actor/fallen_evaluation.h"
#include "common/status_macros.h"
#include "sim/character/model_ptr.h"
#include "sim/motion/rotation.h"
#include "sim/world/body_state.h"
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

// A movement over the floor: turn about the vertical, then shift.
struct FloorMove {
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();

  void Apply(double* root) const {
    Eigen::Map<Eigen::Vector3d> place(root);
    place = turn * Eigen::Vector3d(place) + shift;
    motion::ToWxyz(turn * motion::FromWxyz(root + 3), root + 3);
  }
};

// That which puts the root of one pose over another's place, heading alike.
FloorMove Onto(const double* from, const double* to) {
  FloorMove move;
  move.turn = world::Heading(motion::FromWxyz(to + 3)) *
              world::Heading(motion::FromWxyz(from + 3)).conjugate();
  const Eigen::Vector3d place =
      move.turn * Eigen::Map<const Eigen::Vector3d>(from);
  move.shift = {to[0] - place.x(), to[1] - place.y(), 0};
  return move;
}

// The reference of a start from the floor, [frames, nq] for those of
// `recording`. Where the body went on elsewhere, from there on both are moved
// back to where it was, so that a film has no jumps.
void AddReference(const Subject& subject, const v1::EvaluationStart& start,
                  const v1::EvaluationResult& result, Recording* recording) {
  const int root = subject.character().root_qpos_address();
  const int nq = recording->nq, frames = recording->frames();
  // Parts of the start: the frame that each begins after, and its clip.
  std::vector<v1::EvaluationResult::Carried> parts(result.carried().begin(),
                                                   result.carried().end());
  v1::EvaluationResult::Carried first;
  first.set_clip(result.clip());
  first.set_start_frame(result.start_frame());
  parts.insert(parts.begin(), first);
  std::vector<double>& reference = recording->reference;
  for (size_t part = 0; part < parts.size(); ++part) {
    const int begin = parts[part].after_frames();
    const int end =
        part + 1 < parts.size() ? parts[part + 1].after_frames() : frames - 1;
    std::vector<double> clip = ReferencePoses(
        subject.character(), subject.library(), parts[part].clip(),
        parts[part].start_frame(), end - begin + 2);
    if (part > 0) {
      const FloorMove back =
          Onto(clip.data() + root,
               recording->simulated.data() + int64_t{begin} * nq + root);
      for (size_t i = 0; i < clip.size(); i += nq) back.Apply(&clip[i + root]);
      for (int frame = begin + 1; frame <= end; ++frame) {
        back.Apply(recording->simulated.data() + int64_t{frame} * nq + root);
      }
    }
    // What stands is the frame that the first step is compared with.
    const int stands = part == 0 ? start.recovery_steps() : 0;
    for (int frame = part == 0 ? 0 : begin + 1; frame <= end; ++frame) {
      const int shown = frame == 0 ? 0 : std::max(1, frame - begin - stands);
      const auto pose = clip.begin() + int64_t{shown} * nq;
      reference.insert(reference.end(), pose, pose + nq);
    }
  }
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
  AddReference(subject, start, result, &recording);
  return recording;
}

}  // namespace sinew::evaluation
