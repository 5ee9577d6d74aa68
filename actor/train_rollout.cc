#include <algorithm>
#include <vector>

#include "actor/segment_writer.h"
#include "actor/worker_state.h"
#include "common/random/philox.h"
#include "common/segment/episode_actor.h"
#include "common/status_macros.h"

namespace sinew::actor {
namespace {

// One training order at work.
class TrainRollout {
 public:
  TrainRollout(const v1::Order& order, const PreparedSnapshot& snapshot,
               WorkerState& state, v1::Segment* segment)
      : order_(order),
        snapshot_(snapshot),
        state_(state),
        task_(state.task),
        distillation_(task_.recipe().has_distillation()),
        segment_(segment),
        size_(order.states_size()),
        writer_(state.assets->layout(), order.horizon(), size_, segment) {}

  absl::Status Run(const std::atomic<bool>* cancel) {
    SINEW_RETURN_IF_ERROR(LoadStates());
    for (int step = 0; step < order_.horizon(); ++step) {
      SINEW_RETURN_IF_ERROR(CheckCancelled(cancel, order_));
      for (int e = 0; e < size_; ++e) SINEW_RETURN_IF_ERROR(Prepare(e));
      clock_.Lap(&stages_.observe);
      state_.policy.Run(size_);
      RunOthers();
      clock_.Lap(&stages_.infer);
      for (int e = 0; e < size_; ++e) {
        SINEW_RETURN_IF_ERROR(StepEnvironment(step, e));
      }
    }
    Finish();
    return absl::OkStatus();
  }

 private:
  absl::Status LoadStates() {
    for (int e = 0; e < size_; ++e) {
      Environment& environment = state_.environments[e];
      environment.index = order_.first_environment() + e;
      SINEW_RETURN_IF_ERROR(LoadState(order_.states(e), e,
                                      state_.assets->limits(), &environment,
                                      state_.batch.row(e)));
      if (environment.fresh) continue;
      DrawConditions(&environment);
      const bool ok = state_.batch.Apply(e, /*save=*/false, [&](mjData* data) {
        task_.Refresh(data, state_.work.get());
        Observe(e, data);
      });
      if (!ok) return state_.batch.EngineError(e, "taking up a state");
    }
    return absl::OkStatus();
  }

  // Of the state that is in data and in the workspace's body, into the policy's
  // input.
  void Observe(int e, mjData* data) {
    const Environment& environment = state_.environments[e];
    task_.Observe(data, environment.episode, environment.previous_target,
                  state_.policy.observation(e), state_.work.get(),
                  ConditionsOf(environment));
  }

  void DrawConditions(Environment* environment) {
    task_.DrawConditions(Key(*environment, RandomPurpose::kModelField),
                         &environment->conditions, state_.work.get());
  }
  const world::Conditions* ConditionsOf(const Environment& environment) const {
    return task_.randomisation().on() ? &environment.conditions : nullptr;
  }

  RandomKey Key(const Environment& environment, RandomPurpose purpose) const {
    return {.seed = order_.seed(),
            .environment = static_cast<uint64_t>(environment.index),
            .episode = static_cast<uint64_t>(environment.episode.episode),
            .step = static_cast<uint64_t>(environment.episode.step),
            .purpose = purpose};
  }

  // Begins the episode of a fresh environment; draws the step's noise.
  absl::Status Prepare(int e) {
    Environment& environment = state_.environments[e];
    if (environment.fresh) SINEW_RETURN_IF_ERROR(Begin(e, &environment));
    state_.policy.DrawNoise(e, Key(environment, RandomPurpose::kAction));
    return absl::OkStatus();
  }

  // Who acts where at this step, and the actions of those that are not the
  // policy.
  void RunOthers() {
    int teachers = 0, priors = 0;
    for (int e = 0; e < size_; ++e) {
      const Environment& environment = state_.environments[e];
      WorkerState::Acting& acting = state_.acting[e];
      acting = {
          .actor = WhoActs(task_.recipe().distillation(), order_.seed(),
                           environment.index, environment.episode.episode),
          .runner = &state_.policy,
          .row = e};
      if (acting.actor == EpisodeActor::kPolicy) continue;
      const bool teacher = acting.actor == EpisodeActor::kTeacher;
      PolicyRunner& runner = teacher ? state_.teacher : state_.prior;
      acting.runner = &runner;
      acting.row = teacher ? teachers++ : priors++;
      // What the prior sees is what observations begin with.
      const absl::Span<float> seen = runner.observation(acting.row);
      std::copy_n(state_.policy.observation(e).begin(), seen.size(),
                  seen.begin());
      if (teacher) continue;
      runner.DrawNoise(acting.row, Key(environment, RandomPurpose::kAction),
                       task_.recipe().distillation().prior_noise());
    }
    if (teachers > 0) state_.teacher.Run(teachers);
    if (priors > 0) state_.prior.Run(priors);
  }

  absl::Status Begin(int e, Environment* environment) {
    world::Episode& episode = environment->episode;
    const world::StartFrame start = snapshot_.starts().Draw(
        order_.seed(), static_cast<uint64_t>(environment->index),
        static_cast<uint64_t>(episode.episode));
    episode.clip = start.clip;
    episode.start_frame = start.frame;
    environment->fresh = false;
    const RandomKey noise = Key(*environment, RandomPurpose::kStartNoise);
    const world::BodyStart body = task_.DrawStart(noise);
    DrawConditions(environment);
    const bool ok = state_.batch.Apply(e, /*save=*/true, [&](mjData* data) {
      task_.Begin(body, &noise, data, &episode,
                  absl::MakeSpan(environment->previous_target),
                  state_.work.get(), ConditionsOf(*environment));
      Observe(e, data);
    });
    return ok ? absl::OkStatus()
              : state_.batch.EngineError(e, "beginning an episode");
  }

  absl::Status StepEnvironment(int step, int e) {
    const WorkerState::Acting& acting = state_.acting[e];
    const double log_probability =
        acting.actor == EpisodeActor::kTeacher
            ? 0
            : acting.runner->LogProbability(acting.row);
    SINEW_RETURN_IF_ERROR(CheckPolicyOutput(*acting.runner, acting.row,
                                            log_probability, snapshot_));
    Environment& environment = state_.environments[e];
    const world::Episode before = environment.episode;
    const absl::Span<const float> action = ActionOf(acting, environment);
    world::StepResult result;
    const auto write = [&] {
      writer_.WriteStep(
          step, e,
          {.observation = state_.policy.observation(e),
           .action = action,
           .action_mean = acting.runner->mean(acting.row),
           .target = state_.target,
           .base = state_.base,
           .teacher_base = state_.teacher_base,
           .latent_noise = acting.runner->latent_noise(acting.row),
           .log_probability = log_probability,
           .clip = before.clip,
           .frame = ClipRow(before),
           .result = &result});
    };
    const bool ok = state_.batch.Apply(e, /*save=*/true, [&](mjData* data) {
      result = StepPhysics(e, action, data);
      write();
      // The observation of s_t is written: its place takes that of s_{t+1},
      // where somebody will read it.
      const bool last = step + 1 == order_.horizon();
      if (!result.diverged && (!result.terminated || last)) Observe(e, data);
    });
    if (!ok) {
      environment.episode = before;
      ++environment.episode.step;
      result = world::DivergedStep();
      write();
    }
    AfterStep(step, e, result);
    return absl::OkStatus();
  }

  // What is done at this step, with the noise that a student explores by.
  absl::Span<const float> ActionOf(const WorkerState::Acting& acting,
                                   const Environment& environment) {
    const absl::Span<const float> action = acting.runner->action(acting.row);
    const double noise = task_.recipe().distillation().action_noise();
    if (noise == 0 || acting.actor != EpisodeActor::kPolicy) return action;
    std::vector<float>& noisy = state_.noisy_action;
    FillNormal(Key(environment, RandomPurpose::kStudentNoise),
               absl::MakeSpan(noisy));
    for (size_t i = 0; i < noisy.size(); ++i) {
      noisy[i] = action[i] + static_cast<float>(noise) * noisy[i];
    }
    return noisy;
  }

  world::StepResult StepPhysics(int e, absl::Span<const float> action,
                                mjData* data) {
    Environment& environment = state_.environments[e];
    PlaceTarget(state_.acting[e], action, data, environment);
    clock_.Lap(&stages_.observe);
    const world::ActuationResult physics =
        task_.Simulate(data, environment.episode, state_.target,
                       absl::MakeSpan(environment.previous_target),
                       ConditionsOf(environment), state_.work.get());
    clock_.Lap(&stages_.simulate);
    world::StepResult result =
        task_.Finish(data, physics, &environment.episode, state_.work.get());
    CutOff(state_.acting[e], environment.episode, &result);
    return result;
  }

  // Ends an episode of the prior before it is far from its reference, but not
  // while the body recovers.
  void CutOff(const WorkerState::Acting& acting, const world::Episode& episode,
              world::StepResult* result) const {
    if (acting.actor != EpisodeActor::kPrior || result->terminated ||
        episode.recovery_steps_left > 0 ||
        episode.step - episode.frozen_steps <
            task_.recipe().distillation().prior_steps()) {
      return;
    }
    result->truncated = true;
  }

  // Target and bases of the step at hand.
  void PlaceTarget(const WorkerState::Acting& acting,
                   absl::Span<const float> action, const mjData* data,
                   const Environment& environment) {
    const world::Conditions* conditions = ConditionsOf(environment);
    const world::Episode& episode = environment.episode;
    const absl::Span<double> target = absl::MakeSpan(state_.target);
    if (acting.actor == EpisodeActor::kTeacher) {
      task_.TeacherTarget(data, episode, action, target, state_.work.get(),
                          conditions);
    } else {
      task_.Target(data, episode, action, target, state_.work.get(),
                   conditions);
    }
    if (!distillation_) return;
    task_.Bases(data, episode, absl::MakeSpan(state_.base),
                absl::MakeSpan(state_.teacher_base), state_.work.get(),
                conditions);
  }

  // Row of the clip that is current at an episode's state.
  int32_t ClipRow(const world::Episode& episode) const {
    return static_cast<int32_t>(
        world::CurrentFrame(episode) %
        task_.library().clip(episode.clip).num_frames());
  }

  void AfterStep(int step, int e, const world::StepResult& result) {
    const absl::Span<float> observation = state_.policy.observation(e);
    if (result.diverged) {
      ++diverged_;
      std::fill(observation.begin(), observation.end(), 0.F);
    }
    if (result.truncated) writer_.WriteTruncation(step, e, observation);
    if (step + 1 == order_.horizon()) writer_.WriteBoundary(e, observation);
    if (!result.terminated && !result.truncated) return;
    const world::NearestFrames* frames = FramesAfter(e, result);
    EndEpisode(result, &state_.environments[e]);
    if (frames != nullptr) CarryOn(e, *frames);
  }

  // Where the body goes on after the episode that ends, null if it does not:
  // after a get-up, after one that the prior has led, and after a share of all
  // that came to their clip's end.
  const world::NearestFrames* FramesAfter(
      int e, const world::StepResult& result) const {
    if (result.diverged) return nullptr;
    const Environment& environment = state_.environments[e];
    const v1::StartKind kind = environment.episode.start_kind;
    if (result.clip_end && kind == v1::START_KIND_GET_UP) {
      return state_.upright;
    }
    if (state_.acting[e].actor == EpisodeActor::kPrior) return state_.nearest;
    return result.clip_end && GoesOn(environment) ? state_.onward : nullptr;
  }

  bool GoesOn(const Environment& environment) const {
    const double share = task_.recipe().task().start().carry_on_share();
    return share > 0 &&
           Uniform(Key(environment, RandomPurpose::kCarryOn)) < share;
  }

  // Lets the body go on from where it is, if it can.
  void CarryOn(int e, const world::NearestFrames& frames) {
    Environment& environment = state_.environments[e];
    DrawConditions(&environment);
    bool carried = false;
    const double most = task_.recipe().task().termination().max_body_distance();
    const bool ok = state_.batch.Apply(e, /*save=*/true, [&](mjData* data) {
      carried = task_.CarryOn(frames, most, data, &environment.episode,
                              state_.work.get());
      if (carried) Observe(e, data);
    });
    environment.fresh = !(ok && carried);
  }

  void EndEpisode(const world::StepResult& result, Environment* environment) {
    const world::Episode& episode = environment->episode;
    v1::EpisodeEnd* end = segment_->add_episodes();
    end->set_environment(environment->index);
    end->set_episode(episode.episode);
    end->set_reason(result.diverged     ? v1::EpisodeEnd::REASON_DIVERGED
                    : result.terminated ? v1::EpisodeEnd::REASON_TERMINATED
                    : result.clip_end   ? v1::EpisodeEnd::REASON_CLIP_END
                                        : v1::EpisodeEnd::REASON_TIME_LIMIT);
    end->set_clip(episode.clip);
    end->set_start_frame(episode.start_frame);
    end->set_start_kind(episode.start_kind);
    end->set_steps(episode.step);
    end->set_episode_return(episode.episode_return);
    // A diverged step has no distance.
    const int measured = episode.step - (result.diverged ? 1 : 0);
    end->set_mean_body_distance(measured > 0 ? episode.episode_error / measured
                                             : 0);
    BeginNextEpisode(environment);
  }

  void Finish() {
    writer_.Finish();
    for (int e = 0; e < size_; ++e) {
      SaveState(state_.environments[e], state_.batch.row(e),
                segment_->add_end_states());
    }
    segment_->set_diverged(diverged_);
    segment_->set_physics_steps(int64_t{order_.horizon()} * size_ *
                                task_.substeps());
    clock_.Lap(&stages_.observe);
    v1::StageSeconds* seconds = segment_->mutable_seconds();
    seconds->set_simulate(stages_.simulate);
    seconds->set_infer(stages_.infer);
    seconds->set_observe(stages_.observe);
  }

  const v1::Order& order_;
  const PreparedSnapshot& snapshot_;
  WorkerState& state_;
  const world::TrackingTask& task_;
  const bool distillation_;
  v1::Segment* const segment_;
  const int size_;
  SegmentWriter writer_;
  StageClock clock_;
  Stages stages_;
  int diverged_ = 0;
};

}  // namespace

absl::Status RunTraining(const v1::Order& order,
                         const PreparedSnapshot& snapshot,
                         const std::atomic<bool>* cancel, WorkerState& state,
                         v1::Segment* segment) {
  return TrainRollout(order, snapshot, state, segment).Run(cancel);
}

}  // namespace sinew::actor
