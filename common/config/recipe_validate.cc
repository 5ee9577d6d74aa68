#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/config/distillation_validate.h"
#include "common/config/field_checker.h"
#include "common/config/layer_widths.h"
#include "common/config/procedure_validate.h"
#include "common/config/recipe.h"
#include "common/config/variants_validate.h"
#include "google/protobuf/repeated_field.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew {
namespace {

constexpr int kFormatVersion = 1;
// The learner keeps the snapshots of so many iterations.
constexpr int kMaxEvaluationDelay = 2;
// Longer than any clip.
constexpr double kMaxStartSeconds = 1e6;
// Frames of a start are counted in 32 bits, whatever the rate.
constexpr double kMaxEvaluationSeconds = 86400;

bool IsName(absl::string_view name) {
  return std::all_of(name.begin(), name.end(), [](char c) {
    return absl::ascii_islower(c) || absl::ascii_isdigit(c) || c == '_';
  });
}

// True for positive rates whose ratio is an integer >= 1 but for rounding.
bool IsMultiple(double rate, double of) {
  const double ratio = rate / of;
  return ratio >= 1 && ratio < 1e6 &&
         std::abs(ratio - std::round(ratio)) < 1e-9;
}

void CheckPhysics(const v1::Physics& physics, FieldChecker& check) {
  check.Positive(physics.control_hz(), "physics.control_hz");
  check.Positive(physics.physics_hz(), "physics.physics_hz");
  check.Require(IsMultiple(physics.physics_hz(), physics.control_hz()),
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

void CheckObservation(const v1::Observation& observation, FieldChecker& check) {
  std::set<int> seen;
  for (const int block : observation.blocks()) {
    check.Require(block != v1::Observation::BLOCK_UNSPECIFIED &&
                      v1::Observation::Block_IsValid(block),
                  "task.observation.blocks", "a known block", block);
    check.Require(seen.insert(block).second, "task.observation.blocks",
                  "each block at most once",
                  v1::Observation::Block_Name(block));
  }
  for (const int frame : observation.frames_ahead()) {
    check.Within(frame, 1, 10000, "task.observation.frames_ahead");
  }
}

void CheckReward(const v1::Reward& reward, FieldChecker& check) {
  check.AtLeast(reward.position_weight(), 0, "task.reward.position_weight");
  check.AtLeast(reward.rotation_weight(), 0, "task.reward.rotation_weight");
  check.AtLeast(reward.linear_velocity_weight(), 0,
                "task.reward.linear_velocity_weight");
  check.AtLeast(reward.angular_velocity_weight(), 0,
                "task.reward.angular_velocity_weight");
  const double sum = reward.position_weight() + reward.rotation_weight() +
                     reward.linear_velocity_weight() +
                     reward.angular_velocity_weight();
  check.Require(sum > 0, "task.reward", "weights that are not all 0", sum);
  check.Positive(reward.position_kernel(), "task.reward.position_kernel");
  check.Positive(reward.rotation_kernel(), "task.reward.rotation_kernel");
  check.Positive(reward.linear_velocity_kernel(),
                 "task.reward.linear_velocity_kernel");
  check.Positive(reward.angular_velocity_kernel(),
                 "task.reward.angular_velocity_kernel");
  check.AtLeast(reward.power_cost(), 0, "task.reward.power_cost");
}

void CheckOnlyClips(const v1::Start& start, FieldChecker& check) {
  std::set<absl::string_view> seen;
  for (const std::string& name : start.only_clips()) {
    check.Require(!name.empty(), "task.start.only_clips", "names of clips",
                  name);
    check.Require(seen.insert(name).second, "task.start.only_clips",
                  "each clip at most once", name);
  }
  const double others = start.other_clips_share();
  check.Require(others >= 0 && others < 1, "task.start.other_clips_share",
                "[0, 1)", others);
  check.Require(others == 0 || start.only_clips_size() > 0,
                "task.start.other_clips_share",
                "0, since task.start.only_clips names none", others);
}

void CheckCarryOn(const v1::Start& start, FieldChecker& check) {
  const double share = start.carry_on_share();
  check.Require(share >= 0 && share < 1, "task.start.carry_on_share", "[0, 1)",
                share);
  if (share == 0) {
    check.Require(start.carry_on_seconds() == 0, "task.start.carry_on_seconds",
                  "unset, since task.start.carry_on_share is 0",
                  start.carry_on_seconds());
    return;
  }
  check.Positive(start.carry_on_seconds(), "task.start.carry_on_seconds");
  check.Within(start.carry_on_seconds(), 0, kMaxStartSeconds,
               "task.start.carry_on_seconds");
}

void CheckStart(const v1::Start& start, FieldChecker& check) {
  check.Require(start.rule() != v1::Start::RULE_UNSPECIFIED &&
                    v1::Start::Rule_IsValid(start.rule()),
                "task.start.rule", "a known rule",
                static_cast<int>(start.rule()));
  check.Positive(start.bin_seconds(), "task.start.bin_seconds");
  check.Within(start.bin_seconds(), 0, kMaxStartSeconds,
               "task.start.bin_seconds");
  check.Within(start.uniform_share(), 0, 1, "task.start.uniform_share");
  check.AtLeast(start.joint_position_noise(), 0,
                "task.start.joint_position_noise");
  check.AtLeast(start.joint_velocity_noise(), 0,
                "task.start.joint_velocity_noise");
  CheckOnlyClips(start, check);
  CheckCarryOn(start, check);
  const v1::AdaptiveBins& adaptive = start.adaptive();
  check.Within(adaptive.pre_failure_seconds(), 0, kMaxStartSeconds,
               "task.start.adaptive.pre_failure_seconds");
  check.AtLeast(adaptive.half_life_passages(), 0,
                "task.start.adaptive.half_life_passages");
  check.Within(adaptive.bin_floor(), 0, 1, "task.start.adaptive.bin_floor");
  check.Within(adaptive.clip_floor(), 0, 1, "task.start.adaptive.clip_floor");
  check.Within(adaptive.clip_cap(), 0, 1, "task.start.adaptive.clip_cap");
  check.Require(v1::AdaptiveBins::ClipWeight_IsValid(adaptive.clip_weight()),
                "task.start.adaptive.clip_weight", "a known weight",
                static_cast<int>(adaptive.clip_weight()));
  // Elsewhere zero is unset.
  if (start.rule() != v1::Start::RULE_ADAPTIVE_BINS) return;
  check.Positive(adaptive.half_life_passages(),
                 "task.start.adaptive.half_life_passages");
  check.Positive(adaptive.clip_cap(), "task.start.adaptive.clip_cap");
}

void CheckTask(const v1::Task& task, FieldChecker& check) {
  CheckObservation(task.observation(), check);
  CheckAction(task.action(), "task.action", check);
  CheckReward(task.reward(), check);
  check.Positive(task.termination().max_body_distance(),
                 "task.termination.max_body_distance");
  CheckStart(task.start(), check);
  check.AtLeast(task.max_episode_steps(), 1, "task.max_episode_steps");
  CheckVariants(task, check);
}

void CheckNetwork(const v1::Network& network, FieldChecker& check) {
  CheckLayerWidths(network.policy_hidden(), "network.policy_hidden", check);
  CheckLayerWidths(network.value_hidden(), "network.value_hidden", check);
  check.Require(network.activation() != v1::Network::ACTIVATION_UNSPECIFIED &&
                    v1::Network::Activation_IsValid(network.activation()),
                "network.activation", "a known activation",
                static_cast<int>(network.activation()));
  check.Positive(network.last_layer_gain(), "network.last_layer_gain");
  check.Positive(network.observation_clip(), "network.observation_clip");
  check.Positive(network.initial_std(), "network.initial_std");
}

void CheckRollouts(const v1::Rollouts& rollouts, FieldChecker& check) {
  check.Within(rollouts.environments(), 1, kMostEnvironments,
               "rollouts.environments");
  check.Within(rollouts.horizon(), 1, 1 << 16, "rollouts.horizon");
  const int per_order = rollouts.environments_per_order();
  check.AtLeast(per_order, 1, "rollouts.environments_per_order");
  check.Require(per_order > 0 && rollouts.environments() % per_order == 0,
                "rollouts.environments",
                absl::StrCat("a multiple of rollouts.environments_per_order (",
                             per_order, ")"),
                rollouts.environments());
  check.Within(rollouts.max_policy_lag(), 0, 1, "rollouts.max_policy_lag");
  check.Positive(rollouts.reissue_seconds(), "rollouts.reissue_seconds");
  check.AtLeast(rollouts.replay_bytes(), 1 << 20, "rollouts.replay_bytes");
}

void CheckBatch(const v1::Recipe& recipe, FieldChecker& check) {
  const int64_t batch =
      int64_t{recipe.rollouts().environments()} * recipe.rollouts().horizon();
  const int minibatch = recipe.ppo().minibatch();
  check.AtLeast(minibatch, 1, "ppo.minibatch");
  check.Require(minibatch > 0 && batch % minibatch == 0, "ppo.minibatch",
                absl::StrCat("a divisor of the batch (rollouts.environments * "
                             "rollouts.horizon = ",
                             batch, ")"),
                minibatch);
  const int shards = recipe.ppo().shards();
  check.AtLeast(shards, 1, "ppo.shards");
  check.Require(shards > 0 && minibatch % shards == 0, "ppo.shards",
                absl::StrCat("a divisor of ppo.minibatch (", minibatch, ")"),
                shards);
}

void CheckPpo(const v1::Ppo& ppo, FieldChecker& check) {
  check.Between(ppo.discount(), 0, 1, "ppo.discount");
  check.Within(ppo.gae_lambda(), 0, 1, "ppo.gae_lambda");
  check.Positive(ppo.ratio_clip(), "ppo.ratio_clip");
  check.Within(ppo.epochs(), 1, 1000, "ppo.epochs");
  check.Positive(ppo.policy_learning_rate(), "ppo.policy_learning_rate");
  check.Positive(ppo.value_learning_rate(), "ppo.value_learning_rate");
  check.Positive(ppo.kl_stop(), "ppo.kl_stop");
  check.Positive(ppo.max_gradient_norm(), "ppo.max_gradient_norm");
  check.AtLeast(ppo.entropy_weight(), 0, "ppo.entropy_weight");
  check.AtLeast(ppo.kl_target(), 0, "ppo.kl_target");
  check.AtLeast(ppo.value_warmup_iterations(), 0,
                "ppo.value_warmup_iterations");
  check.AtLeast(ppo.inherited_rows(), 0, "ppo.inherited_rows");
  const v1::Anneal& anneal = ppo.anneal();
  check.Within(anneal.success_share(), 0, 1, "ppo.anneal.success_share");
  check.AtLeast(anneal.samples(), 1, "ppo.anneal.samples");
  check.Positive(anneal.std_factor(), "ppo.anneal.std_factor");
  check.Within(anneal.std_factor(), 0, 1, "ppo.anneal.std_factor");
  check.Positive(anneal.learning_rate_factor(),
                 "ppo.anneal.learning_rate_factor");
  check.Within(anneal.learning_rate_factor(), 0, 1,
               "ppo.anneal.learning_rate_factor");
  check.AtLeast(anneal.stall_evaluations(), 0, "ppo.anneal.stall_evaluations");
  check.AtLeast(anneal.begin_samples(), 0, "ppo.anneal.begin_samples");
  check.AtLeast(anneal.begin_iteration(), 0, "ppo.anneal.begin_iteration");
}

bool FollowsEvaluations(const v1::Start& start) {
  switch (start.rule()) {
    case v1::Start::RULE_PHC_SOFT:
    case v1::Start::RULE_PHC_HARD:
      return true;
    case v1::Start::RULE_ADAPTIVE_BINS:
      return start.adaptive().clip_weight() ==
             v1::AdaptiveBins::CLIP_WEIGHT_EVALUATIONS;
    default:
      return false;
  }
}

// An evaluation begun with snapshot k is waited for at iteration k + delay.
// Under lag L the orders of iteration k + L are the first that are run with
// snapshot k, so waiting any sooner would wait for what nobody has begun.
void CheckEvaluation(const v1::Recipe& recipe, FieldChecker& check) {
  const v1::Evaluation& evaluation = recipe.evaluation();
  const int lag = recipe.rollouts().max_policy_lag();
  check.AtLeast(evaluation.interval(), 0, "evaluation.interval");
  check.Within(evaluation.starts(), 1, 100000, "evaluation.starts");
  check.Positive(evaluation.seconds(), "evaluation.seconds");
  check.Within(evaluation.seconds(), 0, kMaxEvaluationSeconds,
               "evaluation.seconds");
  check.Require(evaluation.delay() >= lag + 1, "evaluation.delay",
                absl::StrCat(">= ", lag + 1,
                             " (rollouts.max_policy_lag + 1), "
                             "or the learner would wait for itself"),
                evaluation.delay());
  check.Within(evaluation.delay(), 1, kMaxEvaluationDelay, "evaluation.delay");
  check.Require(
      evaluation.interval() == 0 || evaluation.delay() <= evaluation.interval(),
      "evaluation.delay",
      absl::StrCat("<= evaluation.interval (", evaluation.interval(), ")"),
      evaluation.delay());
  check.Positive(evaluation.max_mean_body_distance(),
                 "evaluation.max_mean_body_distance");
  const v1::Anneal& anneal = recipe.ppo().anneal();
  const bool anneals =
      anneal.success_share() > 0 || anneal.stall_evaluations() > 0;
  check.Require(!anneals || evaluation.interval() > 0, "evaluation.interval",
                ">= 1, since ppo.anneal waits for evaluations",
                evaluation.interval());
  check.Require(
      !FollowsEvaluations(recipe.task().start()) || evaluation.interval() > 0,
      "evaluation.interval", ">= 1, since task.start follows evaluations",
      evaluation.interval());
}

}  // namespace

absl::Status ValidateRecipe(const v1::Recipe& recipe) {
  FieldChecker check("recipe");
  check.Require(recipe.format_version() == kFormatVersion, "format_version",
                absl::StrCat(kFormatVersion), recipe.format_version());
  check.Require(IsName(recipe.name()), "name",
                "lower-case letters, digits and _", recipe.name());
  check.Require(recipe.device() == "cpu" || recipe.device() == "cuda", "device",
                "\"cpu\" or \"cuda\"", recipe.device());
  check.AtLeast(recipe.max_iterations(), 0, "max_iterations");
  check.AtLeast(recipe.max_minutes(), 0, "max_minutes");
  CheckPhysics(recipe.physics(), check);
  CheckTask(recipe.task(), check);
  CheckNetwork(recipe.network(), check);
  CheckRollouts(recipe.rollouts(), check);
  if (!recipe.has_distillation()) CheckBatch(recipe, check);
  CheckPpo(recipe.ppo(), check);
  const int64_t warmup = recipe.ppo().value_warmup_iterations();
  check.Require(recipe.max_iterations() == 0 ||
                    recipe.max_iterations() > warmup || warmup <= 0,
                "max_iterations",
                absl::StrCat("> ppo.value_warmup_iterations (", warmup,
                             "), or the policy would never learn"),
                recipe.max_iterations());
  CheckEvaluation(recipe, check);
  CheckStages(recipe, check);
  CheckImitation(recipe, check);
  check.AtLeast(recipe.checkpointing().interval(), 1, "checkpointing.interval");
  check.AtLeast(recipe.checkpointing().keep(), 1, "checkpointing.keep");
  return check.status();
}

}  // namespace sinew
