#include "tools/sampling/library_transitions.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/status_macros.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "sim/character/model_ptr.h"
#include "sim/world/body_state.h"
#include "sim/world/tracking_task.h"
#include "tools/evaluation/rollout_pool.h"
#include "tools/sampling/free_body.h"

namespace sinew::sampling {
namespace {

// Transitions of a clip.
int64_t NumTransitions(const v1::ClipInfo& clip) {
  if (clip.left_out()) return 0;
  return clip.loops() ? clip.num_frames()
                      : std::max<int64_t>(0, clip.num_frames() - 1);
}

int64_t NumTransitions(const motion::Library& library) {
  int64_t sum = 0;
  for (int i = 0; i < library.num_clips(); ++i) {
    sum += NumTransitions(library.clip(i));
  }
  return sum;
}

// Pieces of at most `seconds` that follow one another through every clip.
std::vector<v1::EvaluationStart> Pieces(const motion::Library& library,
                                        double seconds) {
  const auto longest = std::max<int64_t>(
      2, std::llround(seconds * library.manifest().frames_per_second()));
  std::vector<v1::EvaluationStart> starts;
  for (int clip = 0; clip < library.num_clips(); ++clip) {
    const int64_t all = NumTransitions(library.clip(clip));
    for (int64_t first = 0; first < all; first += longest) {
      v1::EvaluationStart start;
      start.set_clip(clip);
      start.set_start_frame(static_cast<int32_t>(first));
      start.set_steps(static_cast<int32_t>(std::min(longest, all - first)));
      starts.push_back(start);
    }
  }
  return starts;
}

// Of the frames that one start reached, one after another.
struct Tracked {
  std::vector<double> qpos, qvel;
  std::vector<float> latent;  // of the steps that led to them
};

int64_t NumTransitions(const Tracked& tracked, const mjModel* model) {
  const auto frames = static_cast<int64_t>(tracked.qpos.size()) / model->nq;
  return std::max<int64_t>(0, frames - 1);
}

std::vector<float> StatesOf(const Sampler& sampler, const Tracked& tracked,
                            mjData* data, world::BodyState* state) {
  const mjModel* model = sampler.law().character().model();
  std::vector<float> rows;
  const size_t frames = tracked.qpos.size() / static_cast<size_t>(model->nq);
  for (size_t frame = 0; frame < frames; ++frame) {
    std::copy_n(
        tracked.qpos.begin() + static_cast<ptrdiff_t>(frame) * model->nq,
        model->nq, data->qpos);
    std::copy_n(
        tracked.qvel.begin() + static_cast<ptrdiff_t>(frame) * model->nv,
        model->nv, data->qvel);
    sampler.law().reader().Read(data, state);
    sampler.AppendFeatures(*state, rows);
  }
  return rows;
}

// Foot skate and energy of the clips, played as they are.
absl::Status MeasureClips(const Sampler& sampler,
                          const motion::Library& library, const StopToken& stop,
                          LibraryTransitions* result) {
  const BodyLaw& law = sampler.law();
  const mjModel* model = law.character().model();
  const auto feet = static_cast<int>(law.character().foot_bodies().size());
  const character::DataPtr data(mj_makeData(model));
  FreeBody body(sampler.shared_law());
  for (int clip = 0; clip < library.num_clips(); ++clip) {
    if (stop.stop_requested()) {
      return absl::CancelledError("measuring clips: stopped before its end");
    }
    if (library.clip(clip).left_out()) continue;
    metrics::FootSkateMeter skate(law.foot_of_sole(), feet, law.control_hz());
    metrics::MotionEnergyMeter energy(law.control_hz());
    for (int64_t i = 0; i < library.clip(clip).num_frames(); ++i) {
      world::SetReferencePose(law.character(), library.frame(clip, i),
                              data.get());
      body.Start(absl::MakeConstSpan(data->qpos, model->nq),
                 absl::MakeConstSpan(data->qvel, model->nv));
      skate.Add(body.SolePoints());
      energy.Add(body.state().position, body.state().joint_velocity);
    }
    result->skate.Add(skate.figures());
    result->energy.Add(energy.figures());
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<LibraryTransitions> MakeLibraryTransitions(
    const Sampler& sampler, const motion::Library& library, int64_t most,
    const StopToken& stop) {
  LibraryTransitions result;
  result.all = NumTransitions(library);
  metrics::TransitionSet set(sampler.num_features(), result.all, most);
  const BodyLaw& law = sampler.law();
  world::BodyState state(law.num_bodies(), law.num_joints());
  motion::ReferenceFrame frame(library);
  for (int clip = 0; clip < library.num_clips(); ++clip) {
    const int64_t transitions = NumTransitions(library.clip(clip));
    std::vector<float> rows;
    for (int64_t i = 0; transitions > 0 && i <= transitions; ++i) {
      frame.Load(clip, i);
      law.reader().Read(frame.view(), &state);
      sampler.AppendFeatures(state, rows);
    }
    set.AddMotion(rows);
  }
  if (set.size() == 0) {
    return absl::InvalidArgumentError(
        "library: expected a clip of two frames or more to compare with, "
        "found none");
  }
  result.standardisation = metrics::Standardise(set);
  result.rows = metrics::Standardised(set, result.standardisation);
  SINEW_RETURN_IF_ERROR(MeasureClips(sampler, library, stop, &result));
  return result;
}

absl::Status AddStudent(const Sampler& sampler,
                        const evaluation::Subject& subject, double seconds,
                        int64_t most, int threads, const StopToken& stop,
                        LibraryTransitions* transitions) {
  const std::vector<v1::EvaluationStart> starts =
      Pieces(subject.library(), seconds);
  const mjModel* model = sampler.law().character().model();
  std::vector<Tracked> tracked(starts.size());
  SINEW_RETURN_IF_ERROR(
      evaluation::RunStarts(
          subject.assets, *subject.policy, starts, threads, stop,
          [&](size_t start, int /*frame*/, const mjData& data,
              absl::Span<const float> latent) {
            // Every start has an element of its own.
            Tracked& own = tracked[start];
            own.qpos.insert(own.qpos.end(), data.qpos, data.qpos + model->nq);
            own.qvel.insert(own.qvel.end(), data.qvel, data.qvel + model->nv);
            own.latent.insert(own.latent.end(), latent.begin(), latent.end());
          })
          .status());
  for (const Tracked& own : tracked) {
    transitions->student_all += NumTransitions(own, model);
  }
  metrics::TransitionSet set(sampler.num_features(), transitions->student_all,
                             most);
  const character::DataPtr data(mj_makeData(model));
  world::BodyState state(sampler.law().num_bodies(),
                         sampler.law().num_joints());
  metrics::LatentMeter latent(sampler.latent_width());
  for (const Tracked& own : tracked) {
    set.AddMotion(StatesOf(sampler, own, data.get(), &state));
    latent.AddMotion(own.latent);
  }
  transitions->student_latent = latent.figures();
  if (set.size() == 0) {
    return absl::FailedPreconditionError(
        "--student: expected a policy that survives two steps of a clip, "
        "found none");
  }
  SINEW_ASSIGN_OR_RETURN(
      transitions->student,
      metrics::MatchTransitions(
          transitions->rows,
          metrics::Standardised(set, transitions->standardisation), threads,
          stop));
  return absl::OkStatus();
}

}  // namespace sinew::sampling
