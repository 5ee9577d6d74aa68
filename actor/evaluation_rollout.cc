#include <vector>

#include "actor/fallen_evaluation.h"
#include "actor/worker_state.h"
#include "common/status_macros.h"
#include "sim/metrics/tracking_errors.h"
#include "sim/motion/library.h"
#include "sim/world/get_up_frames.h"
#include "sim/world/recovery.h"

namespace sinew::actor {
namespace {

// One evaluation order at work. Starts that have ended leave the batch, which
// changes nothing for the others.
class EvaluationRollout {
 public:
  EvaluationRollout(const v1::Order& order, const PreparedSnapshot& snapshot,
                    WorkerState& state, v1::Segment* segment)
      : order_(order),
        snapshot_(snapshot),
        state_(state),
        task_(state.task),
        max_distance_(task_.recipe().evaluation().max_mean_body_distance()),
        upright_height_(world::UprightRootHeight(task_.character())),
        segment_(segment) {}

  absl::Status Run(const std::atomic<bool>* cancel) {
    state_.policy.ClearNoise();
    for (int i = 0; i < order_.starts_size(); ++i) {
      SINEW_RETURN_IF_ERROR(Begin(i));
    }
    while (!live_.empty()) {
      SINEW_RETURN_IF_ERROR(CheckCancelled(cancel, order_));
      for (size_t row = 0; row < live_.size(); ++row) {
        SINEW_RETURN_IF_ERROR(Observe(row));
      }
      clock_.Lap(&stages_.observe);
      state_.policy.Run(static_cast<int>(live_.size()));
      clock_.Lap(&stages_.infer);
      size_t kept = 0;
      for (size_t row = 0; row < live_.size(); ++row) {
        bool alive = false;
        SINEW_RETURN_IF_ERROR(Step(row, &alive));
        if (alive) live_[kept++] = live_[row];
      }
      live_.resize(kept);
    }
    Finish();
    return absl::OkStatus();
  }

 private:
  absl::Status Begin(int start) {
    const v1::EvaluationStart& from = order_.starts(start);
    Environment& environment = state_.environments[start];
    environment.index = start;
    environment.fresh = false;
    environment.previous_target.resize(task_.action_width());
    environment.episode = {.episode = 0,
                           .step = 0,
                           .clip = from.clip(),
                           .start_frame = from.start_frame()};
    if (ConditionsOf(environment) != nullptr) {
      task_.DrawConditions(ConditionsKey(from), &environment.conditions,
                           state_.work.get());
    }
    const world::BodyStart body = BodyStartOf(from);
    const bool ok = state_.batch.Apply(start, /*save=*/true, [&](mjData* data) {
      task_.Begin(body, /*noise=*/nullptr, data, &environment.episode,
                  absl::MakeSpan(environment.previous_target),
                  state_.work.get(), ConditionsOf(environment));
    });
    if (!ok) return state_.batch.EngineError(start, "beginning an evaluation");
    begun_.push_back(environment.episode);
    carried_.emplace_back();
    errors_.emplace_back(static_cast<int>(state_.work->body.position.size()),
                         task_.recipe().physics().control_hz());
    failed_at_.push_back(-1);
    watches_.emplace_back(task_.character(), max_distance_);
    live_.push_back(start);
    return absl::OkStatus();
  }

  // Of a start, whichever order it stands in; apart from those of training.
  RandomKey ConditionsKey(const v1::EvaluationStart& from) const {
    const uint64_t fallen = from.has_fallen_state()
                                ? static_cast<uint64_t>(from.fallen_state()) + 1
                                : 0;
    return {.seed = order_.seed(),
            .environment = fallen << 40 | uint64_t{1} << 32 |
                           static_cast<uint64_t>(from.clip()),
            .episode = static_cast<uint64_t>(from.start_frame())};
  }
  const world::Conditions* ConditionsOf(const Environment& environment) const {
    const world::Randomisation& random = task_.randomisation();
    return random.on() && random.in_evaluation() ? &environment.conditions
                                                 : nullptr;
  }

  absl::Status Observe(size_t row) {
    const int start = live_[row];
    const Environment& environment = state_.environments[start];
    const bool ok =
        state_.batch.Apply(start, /*save=*/false, [&](mjData* data) {
          task_.Refresh(data, state_.work.get());
          task_.Observe(data, environment.episode, environment.previous_target,
                        state_.policy.observation(static_cast<int>(row)),
                        state_.work.get(), ConditionsOf(environment));
        });
    return ok ? absl::OkStatus()
              : state_.batch.EngineError(start, "observing a body");
  }

  absl::Status Step(size_t row, bool* alive) {
    const int start = live_[row];
    SINEW_RETURN_IF_ERROR(CheckPolicyOutput(
        state_.policy, static_cast<int>(row), 0.0, snapshot_));
    Environment& environment = state_.environments[start];
    const int frame = environment.episode.step + 1;
    world::StepResult result;
    const bool ok = state_.batch.Apply(start, /*save=*/true, [&](mjData* data) {
      result = StepPhysics(row, data, &environment);
      if (!result.diverged && state_.observer) {
        mj_kinematics(task_.character().model(), data);
        state_.observer(start, frame, *data,
                        state_.policy.latent(static_cast<int>(row)));
      }
    });
    if (!ok) result = world::DivergedStep();
    *alive = Measure(start, result, frame) &&
             (!ClipIsOver(start) || CarryOn(start, frame));
    return absl::OkStatus();
  }

  world::StepResult StepPhysics(size_t row, mjData* data,
                                Environment* environment) {
    task_.Target(data, environment->episode,
                 state_.policy.action(static_cast<int>(row)),
                 absl::MakeSpan(state_.target), state_.work.get(),
                 ConditionsOf(*environment));
    clock_.Lap(&stages_.observe);
    const world::ActuationResult physics =
        task_.Simulate(data, environment->episode, state_.target,
                       absl::MakeSpan(environment->previous_target),
                       ConditionsOf(*environment), state_.work.get());
    clock_.Lap(&stages_.simulate);
    physics_steps_ += task_.substeps();
    return task_.Finish(data, physics, &environment->episode,
                        state_.work.get());
  }

  // Whether a start on a get-up needs another frame to go on with: its clip
  // ends here or, once the body is up, leads down again.
  bool ClipIsOver(int start) const {
    if (!order_.starts(start).get_up()) return false;
    const world::Episode& episode = state_.environments[start].episode;
    const motion::Library& library = task_.library();
    const v1::ClipInfo& clip = library.clip(episode.clip);
    const int64_t next = world::CurrentFrame(episode) + 1;
    if (next > motion::LastFrame(clip)) return true;
    return !carried_[start].empty() &&
           library.frame(episode.clip, next % clip.num_frames())
                   .root_position[2] < upright_height_;
  }

  // Lets the body go on from where it is; false if it cannot, so that the start
  // has failed there.
  bool CarryOn(int start, int frame) {
    world::Episode& episode = state_.environments[start].episode;
    // Its clock goes on: what happens to the body by steps does not begin anew.
    episode = {.step = episode.step, .frozen_steps = episode.step};
    bool carried = false;
    const bool ok = state_.batch.Apply(start, /*save=*/true, [&](mjData* data) {
      carried = task_.CarryOn(*state_.upright, max_distance_, data, &episode,
                              state_.work.get());
    });
    if (!ok || !carried) {
      failed_at_[start] = frame;
      return false;
    }
    errors_[start].Restart();
    v1::EvaluationResult::Carried& to = carried_[start].emplace_back();
    to.set_after_frames(frame);
    to.set_clip(episode.clip);
    to.set_start_frame(episode.start_frame);
    return true;
  }

  // Adds the frame that was reached; false if the start has ended there.
  bool Measure(int start, const world::StepResult& result, int frame) {
    if (result.diverged) {
      ++diverged_;
      failed_at_[start] = frame;
      return false;
    }
    const double distance = errors_[start].Add(state_.work->body.position,
                                               state_.work->reference.position);
    if (order_.starts(start).has_fallen_state()) {
      watches_[start].Add(distance, state_.work->body, state_.work->reference);
    } else if (!(distance <= max_distance_)) {
      failed_at_[start] = frame;
      return false;
    }
    return frame < order_.starts(start).steps();
  }

  void Finish() {
    for (int i = 0; i < order_.starts_size(); ++i) {
      WriteResult(i, segment_->add_results());
    }
    segment_->set_diverged(diverged_);
    segment_->set_physics_steps(physics_steps_);
    clock_.Lap(&stages_.observe);
    v1::StageSeconds* seconds = segment_->mutable_seconds();
    seconds->set_simulate(stages_.simulate);
    seconds->set_infer(stages_.infer);
    seconds->set_observe(stages_.observe);
  }

  void WriteResult(int start, v1::EvaluationResult* result) const {
    const v1::EvaluationStart& from = order_.starts(start);
    const metrics::TrackingErrorSums& sums = errors_[start].sums();
    result->set_clip(begun_[start].clip);
    result->set_start_frame(begun_[start].start_frame);
    result->set_steps(from.steps());
    result->set_success(failed_at_[start] < 0);
    result->set_failed_at_frame(failed_at_[start]);
    result->set_frames(static_cast<int32_t>(sums.frames));
    result->set_velocity_frames(static_cast<int32_t>(sums.velocity_frames));
    result->set_acceleration_frames(
        static_cast<int32_t>(sums.acceleration_frames));
    result->set_sum_g_mpjpe_mm(sums.g_mpjpe_mm);
    result->set_sum_mpjpe_mm(sums.mpjpe_mm);
    result->set_sum_velocity(sums.velocity);
    result->set_sum_acceleration(sums.acceleration);
    for (double sum : sums.body_mm) result->add_sum_body_mm(sum);
    if (!from.has_fallen_state()) return;
    const int recovered_at =
        failed_at_[start] < 0 ? watches_[start].recovered_at() : -1;
    result->set_fallen_state(from.fallen_state());
    result->set_recovered_at_frame(recovered_at);
    result->set_success(recovered_at > 0);
    result->mutable_carried()->Add(carried_[start].begin(),
                                   carried_[start].end());
  }

  const v1::Order& order_;
  const PreparedSnapshot& snapshot_;
  WorkerState& state_;
  const world::TrackingTask& task_;
  const double max_distance_;
  const double upright_height_;  // of the root, m
  v1::Segment* const segment_;
  std::vector<world::Episode> begun_;  // by start: as it began
  std::vector<std::vector<v1::EvaluationResult::Carried>> carried_;  // by start
  std::vector<metrics::TrackingErrors> errors_;                      // by start
  std::vector<int> failed_at_;                                       // by start
  std::vector<world::RecoveryWatch> watches_;                        // by start
  std::vector<int> live_;  // starts still running
  StageClock clock_;
  Stages stages_;
  int64_t physics_steps_ = 0;
  int diverged_ = 0;
};

}  // namespace

absl::Status RunEvaluation(const v1::Order& order,
                           const PreparedSnapshot& snapshot,
                           const std::atomic<bool>* cancel, WorkerState& state,
                           v1::Segment* segment) {
  return EvaluationRollout(order, snapshot, state, segment).Run(cancel);
}

}  // namespace sinew::actor
