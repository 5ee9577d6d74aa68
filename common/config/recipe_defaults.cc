#include <cstdint>
#include <utility>

#include "common/config/recipe.h"
#include "google/protobuf/repeated_field.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew {
namespace {

// Sets a scalar that is unset, that is at zero, to its default.
#define SINEW_DEFAULT(message, field, value)                  \
  do {                                                        \
    if ((message).field() == 0) (message).set_##field(value); \
  } while (false)

// The same for a field with presence, where zero is a value.
#define SINEW_OPTIONAL_DEFAULT(message, field, value)           \
  do {                                                          \
    if (!(message).has_##field()) (message).set_##field(value); \
  } while (false)

void FillPhysics(v1::Physics& physics) {
  SINEW_DEFAULT(physics, physics_hz, 120);
  SINEW_DEFAULT(physics, control_hz, 30);
  SINEW_DEFAULT(physics, solver_iterations, 8);
  SINEW_DEFAULT(physics, line_search_iterations, 8);
  SINEW_DEFAULT(physics, solver_tolerance, 1e-6);
  SINEW_DEFAULT(physics, friction, 1);
}

void FillObservation(v1::Observation& observation) {
  if (observation.blocks_size() == 0) {
    observation.add_blocks(v1::Observation::BLOCK_SELF_JOINT_SPACE);
    observation.add_blocks(v1::Observation::BLOCK_REFERENCE_DIFFERENCE);
  }
  if (observation.frames_ahead_size() == 0) observation.add_frames_ahead(1);
}

void FillReward(v1::Reward& reward) {
  SINEW_OPTIONAL_DEFAULT(reward, position_weight, 0.5);
  SINEW_OPTIONAL_DEFAULT(reward, rotation_weight, 0.3);
  SINEW_OPTIONAL_DEFAULT(reward, linear_velocity_weight, 0.1);
  SINEW_OPTIONAL_DEFAULT(reward, angular_velocity_weight, 0.1);
  SINEW_DEFAULT(reward, position_kernel, 100);
  SINEW_DEFAULT(reward, rotation_kernel, 10);
  SINEW_DEFAULT(reward, linear_velocity_kernel, 0.1);
  SINEW_DEFAULT(reward, angular_velocity_kernel, 0.1);
}

// Only where it is on: a recipe without says nothing of it.
void FillRecovery(v1::Recovery& recovery) {
  if (!(RecoveryShare(recovery) > 0)) return;
  SINEW_DEFAULT(recovery, steps, 90);
  SINEW_DEFAULT(recovery, far_offset, 5);
  SINEW_DEFAULT(recovery, far_distance, 3);
  SINEW_OPTIONAL_DEFAULT(recovery, goal_weight, 9);
  SINEW_DEFAULT(recovery, max_gain, 1.0 / 3);
  SINEW_DEFAULT(recovery, near_distance, 0.25);
  SINEW_DEFAULT(recovery, near_factor, 0.5);
  SINEW_DEFAULT(recovery, fallen_states, 256);
  if (recovery.get_up_share() > 0) {
    SINEW_DEFAULT(recovery, get_up_steps, kGetUpSteps);
  }
}

void FillVariants(v1::Task& task) {
  if (task.has_recovery()) FillRecovery(*task.mutable_recovery());
  if (task.randomisation().push_impulse() > 0) {
    SINEW_DEFAULT(*task.mutable_randomisation(), push_interval, 2);
    SINEW_DEFAULT(*task.mutable_randomisation(), push_seconds, 0.1);
  }
  if (!task.has_actuator_model()) return;
  for (auto& drive : *task.mutable_actuator_model()->mutable_drives()) {
    SINEW_OPTIONAL_DEFAULT(drive, static_friction, 0.45);
    SINEW_DEFAULT(drive, activation_velocity, 0.1);
    SINEW_OPTIONAL_DEFAULT(drive, viscous_friction, 0.023);
    SINEW_DEFAULT(drive, limit_velocity, 20);
    SINEW_DEFAULT(drive, max_velocity, 100);
  }
}

void FillAction(v1::Action& action) {
  SINEW_DEFAULT(action, placement, v1::Action::PLACEMENT_AROUND_NEXT_REFERENCE);
  SINEW_DEFAULT(action, scale, 0.2);
  SINEW_DEFAULT(action, clip, 8);
  SINEW_OPTIONAL_DEFAULT(action, range_margin, 1.5);
}

void FillTask(v1::Task& task) {
  FillObservation(*task.mutable_observation());
  FillAction(*task.mutable_action());
  FillReward(*task.mutable_reward());
  SINEW_DEFAULT(*task.mutable_termination(), max_body_distance, 0.25);
  v1::Start& start = *task.mutable_start();
  SINEW_DEFAULT(start, rule, v1::Start::RULE_UNIFORM);
  SINEW_DEFAULT(start, bin_seconds, 1);
  SINEW_OPTIONAL_DEFAULT(start, uniform_share, 0.1);
  if (start.carry_on_share() > 0) SINEW_DEFAULT(start, carry_on_seconds, 2);
  // Only where it is in force: recipes of other rules print as they always did,
  // and their runs can be resumed.
  if (start.rule() == v1::Start::RULE_ADAPTIVE_BINS) {
    *start.mutable_adaptive() = WithDefaults(start.adaptive());
  }
  SINEW_DEFAULT(task, max_episode_steps, 300);
  FillVariants(task);
}

// Two layers if empty.
void FillHidden(google::protobuf::RepeatedField<int32_t>& widths,
                int first = 256) {
  if (!widths.empty()) return;
  widths.Add(first);
  widths.Add(256);
}

void FillLatent(v1::Latent& latent) {
  SINEW_DEFAULT(latent, width, 32);
  FillHidden(*latent.mutable_encoder_hidden(), 512);
  FillHidden(*latent.mutable_prior_hidden(), 512);
  FillHidden(*latent.mutable_decoder_hidden(), 512);
  SINEW_OPTIONAL_DEFAULT(latent, log_variance_low, -5);
  SINEW_OPTIONAL_DEFAULT(latent, log_variance_high, 2);
}

void FillNetwork(v1::Network& network) {
  FillHidden(*network.mutable_policy_hidden());
  FillHidden(*network.mutable_value_hidden());
  if (network.has_composer()) {
    FillHidden(*network.mutable_composer()->mutable_hidden());
  }
  if (network.has_latent()) FillLatent(*network.mutable_latent());
  SINEW_DEFAULT(network, activation, v1::Network::ACTIVATION_SILU);
  SINEW_DEFAULT(network, last_layer_gain, 0.01);
  SINEW_DEFAULT(network, observation_clip, 8);
  SINEW_DEFAULT(network, initial_std, 0.4);
}

void FillRollouts(v1::Rollouts& rollouts) {
  SINEW_DEFAULT(rollouts, environments, 128);
  SINEW_DEFAULT(rollouts, horizon, 64);
  SINEW_DEFAULT(rollouts, environments_per_order, 8);
  SINEW_DEFAULT(rollouts, reissue_seconds, 20);
  SINEW_DEFAULT(rollouts, replay_bytes, int64_t{256} << 20);
}

void FillPpo(v1::Ppo& ppo) {
  SINEW_DEFAULT(ppo, discount, 0.95);
  SINEW_OPTIONAL_DEFAULT(ppo, gae_lambda, 0.95);
  SINEW_DEFAULT(ppo, ratio_clip, 0.2);
  SINEW_DEFAULT(ppo, epochs, 2);
  SINEW_DEFAULT(ppo, minibatch, 2048);
  SINEW_DEFAULT(ppo, policy_learning_rate, 5e-4);
  SINEW_DEFAULT(ppo, value_learning_rate, 1e-3);
  SINEW_DEFAULT(ppo, kl_stop, 0.05);
  SINEW_DEFAULT(ppo, max_gradient_norm, 1);
  SINEW_DEFAULT(ppo, shards, 2);
  v1::Anneal& anneal = *ppo.mutable_anneal();
  SINEW_DEFAULT(anneal, samples, 500000);
  SINEW_DEFAULT(anneal, std_factor, 0.5);
  SINEW_DEFAULT(anneal, learning_rate_factor, 0.3);
}

// Only where PPO learns a latent: other recipes print as they always did.
void FillLatentPpo(v1::Recipe& recipe) {
  if (RecordedLatentWidth(recipe) == 0) return;
  SINEW_OPTIONAL_DEFAULT(*recipe.mutable_ppo(), latent_kl_weight, 0.001);
}

// Only where they are set, like variants: other recipes print as they always
// did.
void FillStages(v1::Recipe& recipe) {
  if (recipe.has_plateau()) {
    SINEW_OPTIONAL_DEFAULT(*recipe.mutable_plateau(), gain, 0.01);
  }
  if (!recipe.has_procedure()) return;
  v1::Procedure& procedure = *recipe.mutable_procedure();
  SINEW_DEFAULT(procedure, max_primitives, 2);
  SINEW_OPTIONAL_DEFAULT(procedure, learnable_share, 0.1);
  FillHidden(*procedure.mutable_composer_hidden());
}

void FillDistillation(v1::Distillation& distillation) {
  FillAction(*distillation.mutable_teacher_action());
  SINEW_DEFAULT(distillation, form, v1::Distillation::FORM_CODE);
  SINEW_DEFAULT(distillation, learning_rate, 5e-4);
  // Only where they mean something: other recipes print as they always did.
  if (distillation.rate_anneal_end() > 0) {
    SINEW_DEFAULT(distillation, learning_rate_final,
                  distillation.learning_rate());
  }
  if (distillation.prior_share() > 0) {
    SINEW_OPTIONAL_DEFAULT(distillation, prior_noise, 1);
    SINEW_DEFAULT(distillation, prior_steps, 4);
    SINEW_DEFAULT(distillation, prior_seconds_ahead, 0.5);
  }
  SINEW_DEFAULT(distillation, max_gradient_norm, 50);
  SINEW_DEFAULT(distillation, minibatch, 2048);
  SINEW_DEFAULT(distillation, samples_per_insert, 4);
  SINEW_DEFAULT(distillation, shards, 2);
  SINEW_OPTIONAL_DEFAULT(distillation, kl_weight, 0.01);
  SINEW_OPTIONAL_DEFAULT(distillation, kl_weight_final, 0.001);
  SINEW_OPTIONAL_DEFAULT(distillation, continuity_weight, 0.005);
  v1::Distillation::Memory& memory = *distillation.mutable_memory();
  SINEW_DEFAULT(memory, rows, 65536);
  SINEW_DEFAULT(memory, selector, v1::Distillation::Memory::SELECTOR_UNIFORM);
  SINEW_OPTIONAL_DEFAULT(memory, priority_exponent, 0.6);
}

void FillEvaluation(int max_policy_lag, v1::Evaluation& evaluation) {
  SINEW_DEFAULT(evaluation, starts, 32);
  SINEW_DEFAULT(evaluation, seconds, 10);
  SINEW_DEFAULT(evaluation, delay, max_policy_lag + 1);
  SINEW_DEFAULT(evaluation, max_mean_body_distance, 0.5);
}

}  // namespace

v1::AdaptiveBins WithDefaults(v1::AdaptiveBins adaptive) {
  SINEW_OPTIONAL_DEFAULT(adaptive, pre_failure_seconds, 1);
  SINEW_DEFAULT(adaptive, half_life_passages, 30);
  SINEW_OPTIONAL_DEFAULT(adaptive, bin_floor, 0.1);
  SINEW_OPTIONAL_DEFAULT(adaptive, clip_floor, 0.1);
  SINEW_DEFAULT(adaptive, clip_cap, 0.25);
  return adaptive;
}

v1::Recipe WithDefaults(v1::Recipe recipe) {
  SINEW_DEFAULT(recipe, format_version, 1);
  if (recipe.device().empty()) recipe.set_device("cpu");
  FillPhysics(*recipe.mutable_physics());
  FillTask(*recipe.mutable_task());
  FillNetwork(*recipe.mutable_network());
  FillRollouts(*recipe.mutable_rollouts());
  FillPpo(*recipe.mutable_ppo());
  FillLatentPpo(recipe);
  FillEvaluation(recipe.rollouts().max_policy_lag(),
                 *recipe.mutable_evaluation());
  FillStages(recipe);
  if (recipe.has_distillation()) {
    FillDistillation(*recipe.mutable_distillation());
  }
  SINEW_DEFAULT(*recipe.mutable_checkpointing(), interval, 20);
  SINEW_DEFAULT(*recipe.mutable_checkpointing(), keep, 3);
  return recipe;
}

#undef SINEW_DEFAULT
#undef SINEW_OPTIONAL_DEFAULT

}  // namespace sinew
