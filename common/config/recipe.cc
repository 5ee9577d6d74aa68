#include "common/config/recipe.h"

#include <cmath>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/config/text_proto.h"
#include "common/status_macros.h"
#include "google/protobuf/text_format.h"

namespace sinew {
namespace {

constexpr int kFormatVersion = 1;

// Sets a scalar that is unset (zero) to its default.
#define SINEW_DEFAULT(message, field, value)                  \
  do {                                                        \
    if ((message).field() == 0) (message).set_##field(value); \
  } while (false)

void FillPhysics(v1::Physics& physics) {
  SINEW_DEFAULT(physics, physics_hz, 120);
  SINEW_DEFAULT(physics, control_hz, 30);
  SINEW_DEFAULT(physics, solver_iterations, 8);
  SINEW_DEFAULT(physics, line_search_iterations, 8);
  SINEW_DEFAULT(physics, solver_tolerance, 1e-6);
  SINEW_DEFAULT(physics, friction, 1);
}

void FillReward(v1::Reward& reward) {
  // All weights zero means unset; a single zero weight switches a term off.
  if (reward.position_weight() == 0 && reward.rotation_weight() == 0 &&
      reward.linear_velocity_weight() == 0 &&
      reward.angular_velocity_weight() == 0) {
    reward.set_position_weight(0.5);
    reward.set_rotation_weight(0.3);
    reward.set_linear_velocity_weight(0.1);
    reward.set_angular_velocity_weight(0.1);
  }
  SINEW_DEFAULT(reward, position_kernel, 100);
  SINEW_DEFAULT(reward, rotation_kernel, 10);
  SINEW_DEFAULT(reward, linear_velocity_kernel, 0.1);
  SINEW_DEFAULT(reward, angular_velocity_kernel, 0.1);
}

void FillTask(v1::Task& task) {
  v1::Observation& observation = *task.mutable_observation();
  if (observation.blocks_size() == 0) {
    observation.add_blocks(v1::Observation::BLOCK_SELF_JOINT_SPACE);
    observation.add_blocks(v1::Observation::BLOCK_REFERENCE_DIFFERENCE);
  }
  if (observation.frames_ahead_size() == 0) observation.add_frames_ahead(1);
  v1::Action& action = *task.mutable_action();
  SINEW_DEFAULT(action, placement,
                v1::Action::PLACEMENT_AROUND_NEXT_REFERENCE);
  SINEW_DEFAULT(action, scale, 0.2);
  SINEW_DEFAULT(action, clip, 8);
  SINEW_DEFAULT(action, range_margin, 1.5);
  FillReward(*task.mutable_reward());
  SINEW_DEFAULT(*task.mutable_termination(), max_body_distance, 0.25);
  v1::Start& start = *task.mutable_start();
  SINEW_DEFAULT(start, rule, v1::Start::RULE_UNIFORM);
  SINEW_DEFAULT(start, bin_seconds, 1);
  SINEW_DEFAULT(start, uniform_share, 0.1);
  SINEW_DEFAULT(task, max_episode_steps, 300);
}

void FillNetwork(v1::Network& network) {
  if (network.policy_hidden_size() == 0) {
    network.add_policy_hidden(256);
    network.add_policy_hidden(256);
  }
  if (network.value_hidden_size() == 0) {
    network.add_value_hidden(256);
    network.add_value_hidden(256);
  }
  SINEW_DEFAULT(network, activation, v1::Network::ACTIVATION_SILU);
  SINEW_DEFAULT(network, last_layer_gain, 0.01);
  SINEW_DEFAULT(network, observation_clip, 8);
  SINEW_DEFAULT(network, initial_std, 0.4);
}

void FillLearning(v1::Recipe& recipe) {
  v1::Rollouts& rollouts = *recipe.mutable_rollouts();
  SINEW_DEFAULT(rollouts, environments, 128);
  SINEW_DEFAULT(rollouts, horizon, 64);
  SINEW_DEFAULT(rollouts, environments_per_order, 8);
  SINEW_DEFAULT(rollouts, reissue_seconds, 20);
  SINEW_DEFAULT(rollouts, replay_bytes, int64_t{256} << 20);
  v1::Ppo& ppo = *recipe.mutable_ppo();
  SINEW_DEFAULT(ppo, discount, 0.95);
  SINEW_DEFAULT(ppo, gae_lambda, 0.95);
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
  v1::Evaluation& evaluation = *recipe.mutable_evaluation();
  SINEW_DEFAULT(evaluation, starts, 32);
  SINEW_DEFAULT(evaluation, seconds, 10);
  SINEW_DEFAULT(evaluation, delay, 1);
  SINEW_DEFAULT(evaluation, max_mean_body_distance, 0.5);
  v1::Checkpointing& checkpointing = *recipe.mutable_checkpointing();
  SINEW_DEFAULT(checkpointing, interval, 20);
  SINEW_DEFAULT(checkpointing, keep, 3);
}

#undef SINEW_DEFAULT

// Collects the first violated rule.
class Checker {
 public:
  void Require(bool holds, absl::string_view field, absl::string_view expected,
               double found) {
    if (holds || !status_.ok()) return;
    status_ = absl::InvalidArgumentError(absl::StrCat(
        "recipe field ", field, ": expected ", expected, ", found ", found));
  }
  void Positive(double value, absl::string_view field) {
    Require(value > 0 && std::isfinite(value), field, "> 0", value);
  }
  void NotNegative(double value, absl::string_view field) {
    Require(value >= 0 && std::isfinite(value), field, ">= 0", value);
  }
  void AtLeast(double value, double least, absl::string_view field) {
    Require(value >= least && std::isfinite(value), field,
            absl::StrCat(">= ", least), value);
  }
  void Within(double value, double low, double high, absl::string_view field) {
    Require(value >= low && value <= high, field,
            absl::StrCat("within [", low, ", ", high, "]"), value);
  }
  void Open(double value, double low, double high, absl::string_view field) {
    Require(value > low && value < high, field,
            absl::StrCat("within (", low, ", ", high, ")"), value);
  }
  const absl::Status& status() const { return status_; }

 private:
  absl::Status status_;
};

void CheckPhysics(const v1::Physics& physics, Checker& check) {
  check.Positive(physics.physics_hz(), "physics.physics_hz");
  check.Positive(physics.control_hz(), "physics.control_hz");
  const double ratio = physics.physics_hz() / physics.control_hz();
  check.Require(ratio >= 1 && std::abs(ratio - std::round(ratio)) < 1e-9,
                "physics.physics_hz",
                absl::StrCat("a multiple of physics.control_hz (",
                             physics.control_hz(), ")"),
                physics.physics_hz());
  check.AtLeast(physics.solver_iterations(), 1, "physics.solver_iterations");
  check.AtLeast(physics.line_search_iterations(), 1,
                "physics.line_search_iterations");
  check.Positive(physics.solver_tolerance(), "physics.solver_tolerance");
  check.Positive(physics.friction(), "physics.friction");
}

void CheckTask(const v1::Task& task, Checker& check) {
  for (int frame : task.observation().frames_ahead()) {
    check.AtLeast(frame, 1, "task.observation.frames_ahead");
  }
  for (int block : task.observation().blocks()) {
    check.Require(block != v1::Observation::BLOCK_UNSPECIFIED &&
                      v1::Observation::Block_IsValid(block),
                  "task.observation.blocks", "a named block", block);
  }
  const v1::Action& action = task.action();
  check.Require(v1::Action::Placement_IsValid(action.placement()),
                "task.action.placement", "a named placement",
                action.placement());
  check.Positive(action.scale(), "task.action.scale");
  check.Positive(action.clip(), "task.action.clip");
  check.NotNegative(action.range_margin(), "task.action.range_margin");
  const bool around_reference =
      action.placement() == v1::Action::PLACEMENT_AROUND_NEXT_REFERENCE;
  check.Require(around_reference || !action.velocity_feedforward(),
                "task.action.velocity_feedforward",
                "false unless placement is AROUND_NEXT_REFERENCE", 1);
  check.Require(around_reference || !action.torque_feedforward(),
                "task.action.torque_feedforward",
                "false unless placement is AROUND_NEXT_REFERENCE", 1);
  const v1::Reward& reward = task.reward();
  check.NotNegative(reward.position_weight(), "task.reward.position_weight");
  check.NotNegative(reward.rotation_weight(), "task.reward.rotation_weight");
  check.NotNegative(reward.linear_velocity_weight(),
                    "task.reward.linear_velocity_weight");
  check.NotNegative(reward.angular_velocity_weight(),
                    "task.reward.angular_velocity_weight");
  check.Positive(reward.position_kernel(), "task.reward.position_kernel");
  check.Positive(reward.rotation_kernel(), "task.reward.rotation_kernel");
  check.Positive(reward.linear_velocity_kernel(),
                 "task.reward.linear_velocity_kernel");
  check.Positive(reward.angular_velocity_kernel(),
                 "task.reward.angular_velocity_kernel");
  check.NotNegative(reward.power_cost(), "task.reward.power_cost");
  check.Positive(task.termination().max_body_distance(),
                 "task.termination.max_body_distance");
  const v1::Start& start = task.start();
  check.Require(v1::Start::Rule_IsValid(start.rule()), "task.start.rule",
                "a named rule", start.rule());
  check.Positive(start.bin_seconds(), "task.start.bin_seconds");
  check.Within(start.uniform_share(), 0, 1, "task.start.uniform_share");
  check.NotNegative(start.joint_position_noise(),
                    "task.start.joint_position_noise");
  check.NotNegative(start.joint_velocity_noise(),
                    "task.start.joint_velocity_noise");
  check.AtLeast(task.max_episode_steps(), 1, "task.max_episode_steps");
}

void CheckNetwork(const v1::Network& network, Checker& check) {
  for (int width : network.policy_hidden()) {
    check.Within(width, 1, 16384, "network.policy_hidden");
  }
  for (int width : network.value_hidden()) {
    check.Within(width, 1, 16384, "network.value_hidden");
  }
  check.Require(v1::Network::Activation_IsValid(network.activation()),
                "network.activation", "a named activation",
                network.activation());
  check.Positive(network.last_layer_gain(), "network.last_layer_gain");
  check.Positive(network.observation_clip(), "network.observation_clip");
  check.Positive(network.initial_std(), "network.initial_std");
}

void CheckRollouts(const v1::Rollouts& rollouts, Checker& check) {
  check.Within(rollouts.environments(), 1, 1 << 20, "rollouts.environments");
  check.Within(rollouts.horizon(), 1, 1 << 16, "rollouts.horizon");
  check.AtLeast(rollouts.environments_per_order(), 1,
                "rollouts.environments_per_order");
  check.Require(rollouts.environments_per_order() > 0 &&
                    rollouts.environments() %
                            rollouts.environments_per_order() ==
                        0,
                "rollouts.environments",
                absl::StrCat("a multiple of rollouts.environments_per_order (",
                             rollouts.environments_per_order(), ")"),
                rollouts.environments());
  check.Within(rollouts.max_policy_lag(), 0, 1, "rollouts.max_policy_lag");
  check.Positive(rollouts.reissue_seconds(), "rollouts.reissue_seconds");
  check.AtLeast(static_cast<double>(rollouts.replay_bytes()), 1 << 20,
                "rollouts.replay_bytes");
}

void CheckPpo(const v1::Recipe& recipe, Checker& check) {
  const v1::Ppo& ppo = recipe.ppo();
  check.Open(ppo.discount(), 0, 1, "ppo.discount");
  check.Within(ppo.gae_lambda(), 0, 1, "ppo.gae_lambda");
  check.Positive(ppo.ratio_clip(), "ppo.ratio_clip");
  check.Within(ppo.epochs(), 1, 1000, "ppo.epochs");
  check.AtLeast(ppo.minibatch(), 1, "ppo.minibatch");
  const int64_t batch = int64_t{recipe.rollouts().environments()} *
                        recipe.rollouts().horizon();
  check.Require(ppo.minibatch() > 0 && batch % ppo.minibatch() == 0,
                "ppo.minibatch",
                absl::StrCat("a divisor of the batch of ", batch, " samples"),
                ppo.minibatch());
  check.Positive(ppo.policy_learning_rate(), "ppo.policy_learning_rate");
  check.Positive(ppo.value_learning_rate(), "ppo.value_learning_rate");
  check.Positive(ppo.kl_stop(), "ppo.kl_stop");
  check.Positive(ppo.max_gradient_norm(), "ppo.max_gradient_norm");
  check.AtLeast(ppo.shards(), 1, "ppo.shards");
  check.Require(ppo.shards() > 0 && ppo.minibatch() % ppo.shards() == 0,
                "ppo.shards",
                absl::StrCat("a divisor of ppo.minibatch (", ppo.minibatch(),
                             ")"),
                ppo.shards());
  check.NotNegative(ppo.entropy_weight(), "ppo.entropy_weight");
  check.NotNegative(ppo.kl_target(), "ppo.kl_target");
  const v1::Anneal& anneal = ppo.anneal();
  check.Within(anneal.success_share(), 0, 1, "ppo.anneal.success_share");
  check.AtLeast(static_cast<double>(anneal.samples()), 1, "ppo.anneal.samples");
  check.Positive(anneal.std_factor(), "ppo.anneal.std_factor");
  check.Positive(anneal.learning_rate_factor(),
                 "ppo.anneal.learning_rate_factor");
  check.NotNegative(anneal.stall_evaluations(),
                    "ppo.anneal.stall_evaluations");
}

void CheckEvaluation(const v1::Recipe& recipe, Checker& check) {
  const v1::Evaluation& evaluation = recipe.evaluation();
  check.NotNegative(evaluation.interval(), "evaluation.interval");
  check.Within(evaluation.starts(), 1, 100000, "evaluation.starts");
  check.Positive(evaluation.seconds(), "evaluation.seconds");
  // Snapshot k exists after update k - 1; under lag 1 its actors are busy with
  // iteration k by then, so an evaluation can be waited for one iteration
  // later at the earliest.
  const int least = 1 + recipe.rollouts().max_policy_lag();
  check.Require(evaluation.delay() >= least, "evaluation.delay",
                absl::StrCat(">= ", least,
                             " (rollouts.max_policy_lag + 1), or the learner "
                             "would wait for itself"),
                evaluation.delay());
  check.Require(evaluation.interval() == 0 ||
                    evaluation.delay() <= evaluation.interval(),
                "evaluation.delay",
                absl::StrCat("<= evaluation.interval (", evaluation.interval(),
                             ")"),
                evaluation.delay());
  check.Positive(evaluation.max_mean_body_distance(),
                 "evaluation.max_mean_body_distance");
  const bool anneals = recipe.ppo().anneal().success_share() > 0 ||
                       recipe.ppo().anneal().stall_evaluations() > 0;
  check.Require(!anneals || evaluation.interval() > 0, "evaluation.interval",
                "> 0, since ppo.anneal waits for evaluations",
                evaluation.interval());
}

}  // namespace

absl::StatusOr<v1::Recipe> ParseRecipe(absl::string_view text,
                                       absl::string_view source) {
  v1::Recipe recipe;
  SINEW_RETURN_IF_ERROR(ParseTextProto(text, source, recipe));
  return recipe;
}

v1::Recipe WithDefaults(v1::Recipe recipe) {
  if (recipe.format_version() == 0) recipe.set_format_version(kFormatVersion);
  if (recipe.device().empty()) recipe.set_device("cpu");
  FillPhysics(*recipe.mutable_physics());
  FillTask(*recipe.mutable_task());
  FillNetwork(*recipe.mutable_network());
  FillLearning(recipe);
  return recipe;
}

absl::Status ValidateRecipe(const v1::Recipe& recipe) {
  Checker check;
  check.Require(recipe.format_version() == kFormatVersion, "format_version",
                absl::StrCat(kFormatVersion), recipe.format_version());
  if (recipe.device() != "cpu" && recipe.device() != "cuda") {
    return absl::InvalidArgumentError(
        absl::StrCat("recipe field device: expected \"cpu\" or \"cuda\", found \"",
                     recipe.device(), "\""));
  }
  CheckPhysics(recipe.physics(), check);
  CheckTask(recipe.task(), check);
  CheckNetwork(recipe.network(), check);
  CheckRollouts(recipe.rollouts(), check);
  CheckPpo(recipe, check);
  CheckEvaluation(recipe, check);
  check.AtLeast(recipe.checkpointing().interval(), 1, "checkpointing.interval");
  check.AtLeast(recipe.checkpointing().keep(), 1, "checkpointing.keep");
  check.NotNegative(static_cast<double>(recipe.max_iterations()),
                    "max_iterations");
  check.NotNegative(recipe.max_minutes(), "max_minutes");
  return check.status();
}

std::string PrintRecipe(const v1::Recipe& recipe) {
  std::string text;
  google::protobuf::TextFormat::PrintToString(recipe, &text);
  return text;
}

}  // namespace sinew
