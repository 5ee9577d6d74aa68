#include "common/config/distillation_validate.h"

#include <cstdint>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/config/layer_widths.h"
#include "common/config/recipe.h"

namespace sinew {
namespace {

constexpr double kMaxSecondsAhead = 1e6;
constexpr int kMaxLatent = 1024;
constexpr int kMaxSamplesPerInsert = 1024;

void CheckOwnState(const v1::Observation& observation, FieldChecker& check) {
  constexpr absl::string_view kPath = "task.observation.blocks";
  const int own = LeadingSelfBlocks(observation);
  check.Require(own > 0 && own < observation.blocks_size(), kPath,
                "the body's own blocks first, then those of the goal, at least "
                "one of each, since network.latent is set",
                absl::StrCat(own, " own blocks, then ",
                             observation.blocks_size() - own, " others"));
  for (int i = own; i < observation.blocks_size(); ++i) {
    check.Require(!IsSelfBlock(observation.blocks(i)), kPath,
                  "all of the body's own blocks before those of the goal, "
                  "since network.latent is set",
                  v1::Observation::Block_Name(observation.blocks(i)));
  }
}

void CheckLatent(const v1::Recipe& recipe, FieldChecker& check) {
  const v1::Latent& latent = recipe.network().latent();
  check.Require(!recipe.network().has_composer(), "network.composer",
                "unset, since network.latent is set", "set");
  check.Within(latent.width(), 1, kMaxLatent, "network.latent.width");
  CheckLayerWidths(latent.encoder_hidden(), "network.latent.encoder_hidden",
                   check);
  CheckLayerWidths(latent.prior_hidden(), "network.latent.prior_hidden", check);
  CheckLayerWidths(latent.decoder_hidden(), "network.latent.decoder_hidden",
                   check);
  check.Require(latent.log_variance_low() < latent.log_variance_high(),
                "network.latent.log_variance_low",
                absl::StrCat("< network.latent.log_variance_high (",
                             latent.log_variance_high(), ")"),
                latent.log_variance_low());
  CheckOwnState(recipe.task().observation(), check);
  const v1::Action::Placement placement = recipe.task().action().placement();
  check.Require(IsBlindPlacement(placement), "task.action.placement",
                "PLACEMENT_AROUND_CURRENT or PLACEMENT_ABSOLUTE, since the "
                "decoder of network.latent sees no reference",
                v1::Action::Placement_Name(placement));
}

// Of a latent that PPO learns, and where there is none.
void CheckLatentPpo(const v1::Recipe& recipe, FieldChecker& check) {
  const v1::Ppo& ppo = recipe.ppo();
  if (RecordedLatentWidth(recipe) == 0) {
    check.Require(!ppo.has_latent_kl_weight(), "ppo.latent_kl_weight",
                  "unset, since PPO learns no network.latent",
                  ppo.latent_kl_weight());
    return;
  }
  check.AtLeast(ppo.latent_kl_weight(), 0, "ppo.latent_kl_weight");
  check.Require(!ppo.mirror(), "ppo.mirror",
                "unset, since network.latent is set and its noise has no "
                "mirror image",
                ppo.mirror());
  check.Require(!recipe.has_procedure(), "procedure",
                "unset, since network.latent is set", "set");
}

// Of episodes in which others than the student act.
void CheckShares(const v1::Recipe& recipe, FieldChecker& check) {
  const double teacher = recipe.distillation().teacher_share();
  const double prior = recipe.distillation().prior_share();
  check.Within(teacher, 0, 1, "distillation.teacher_share");
  check.Within(prior, 0, 1, "distillation.prior_share");
  check.Require(
      teacher + prior <= 1, "distillation.prior_share",
      absl::StrCat("<= 1 - distillation.teacher_share (", 1 - teacher, ")"),
      prior);
  check.Require(prior < 1, "distillation.prior_share",
                "< 1, since what the student leads itself is what observations "
                "are normalised by",
                prior);
  check.Require(
      prior == 0 || recipe.network().has_latent(), "distillation.prior_share",
      "0, since network.latent is unset and there is no prior", prior);
  const v1::Distillation& distillation = recipe.distillation();
  if (prior > 0) {
    check.Within(distillation.prior_noise(), 0, 100,
                 "distillation.prior_noise");
    check.AtLeast(distillation.prior_steps(), 1, "distillation.prior_steps");
    check.AtLeast(distillation.prior_first_episode(), 0,
                  "distillation.prior_first_episode");
    check.Positive(distillation.prior_seconds_ahead(),
                   "distillation.prior_seconds_ahead");
    check.Within(distillation.prior_seconds_ahead(), 0, kMaxSecondsAhead,
                 "distillation.prior_seconds_ahead");
    return;
  }
  constexpr absl::string_view kUnset =
      "unset, since distillation.prior_share is 0";
  check.Require(!distillation.has_prior_noise(), "distillation.prior_noise",
                kUnset, distillation.prior_noise());
  check.Require(distillation.prior_steps() == 0, "distillation.prior_steps",
                kUnset, distillation.prior_steps());
  check.Require(distillation.prior_first_episode() == 0,
                "distillation.prior_first_episode", kUnset,
                distillation.prior_first_episode());
  check.Require(distillation.prior_seconds_ahead() == 0,
                "distillation.prior_seconds_ahead", kUnset,
                distillation.prior_seconds_ahead());
}

void CheckTeacher(const v1::Recipe& recipe, FieldChecker& check) {
  const v1::Action& teacher = recipe.distillation().teacher_action();
  const v1::Action& student = recipe.task().action();
  CheckAction(teacher, "distillation.teacher_action", check);
  check.Require(teacher.ramp() == student.ramp(),
                "distillation.teacher_action.ramp",
                "the same as task.action.ramp, or the student's body would "
                "follow the teacher's targets in another way",
                teacher.ramp());
  check.Require(student.range_margin() >= teacher.range_margin(),
                "task.action.range_margin",
                absl::StrCat(">= distillation.teacher_action.range_margin (",
                             teacher.range_margin(),
                             "), or some of the teacher's targets would be out "
                             "of reach"),
                student.range_margin());
}

// Sequences of one environment and order are what minibatches are made of.
void CheckMinibatch(const v1::Recipe& recipe, FieldChecker& check) {
  const v1::Distillation& distillation = recipe.distillation();
  const int horizon = recipe.rollouts().horizon();
  const int minibatch = distillation.minibatch();
  check.AtLeast(minibatch, 1, "distillation.minibatch");
  check.Require(horizon > 0 && minibatch % horizon == 0,
                "distillation.minibatch",
                absl::StrCat("a multiple of rollouts.horizon (", horizon, ")"),
                minibatch);
  const int shards = distillation.shards();
  const int sequences = horizon > 0 ? minibatch / horizon : 0;
  check.AtLeast(shards, 1, "distillation.shards");
  check.Require(shards > 0 && sequences % shards == 0, "distillation.shards",
                absl::StrCat("a divisor of the sequences of a minibatch "
                             "(distillation.minibatch / rollouts.horizon = ",
                             sequences, ")"),
                shards);
}

void CheckMemory(const v1::Recipe& recipe, FieldChecker& check) {
  const v1::Distillation::Memory& memory = recipe.distillation().memory();
  const int64_t rows =
      int64_t{recipe.rollouts().environments()} * recipe.rollouts().horizon();
  check.Require(memory.rows() >= rows, "distillation.memory.rows",
                absl::StrCat(">= the rows of an iteration "
                             "(rollouts.environments * rollouts.horizon = ",
                             rows, ")"),
                memory.rows());
  check.Require(
      memory.selector() != v1::Distillation::Memory::SELECTOR_UNSPECIFIED &&
          v1::Distillation::Memory::Selector_IsValid(memory.selector()),
      "distillation.memory.selector", "a known selector",
      static_cast<int>(memory.selector()));
  check.Within(memory.priority_exponent(), 0, 1,
               "distillation.memory.priority_exponent");
}

// 0 <= begin <= end.
void CheckMarks(int64_t begin, int64_t end, const std::string& name,
                FieldChecker& check) {
  const std::string path = absl::StrCat("distillation.", name);
  check.AtLeast(begin, 0, path + "_begin");
  check.Require(end >= begin, path + "_end",
                absl::StrCat(">= ", path, "_begin (", begin, ")"), end);
}

void CheckLearningRate(const v1::Distillation& distillation,
                       FieldChecker& check) {
  const double first = distillation.learning_rate();
  const double final = distillation.learning_rate_final();
  const int64_t end = distillation.rate_anneal_end();
  check.Positive(first, "distillation.learning_rate");
  CheckMarks(distillation.rate_anneal_begin(), end, "rate_anneal", check);
  check.Require(final == 0 || end > 0, "distillation.rate_anneal_end",
                "> 0, since distillation.learning_rate_final is set", end);
  check.Require(
      end == 0 || (final > 0 && final <= first),
      "distillation.learning_rate_final",
      absl::StrCat("> 0 and <= distillation.learning_rate (", first, ")"),
      final);
}

void CheckLosses(const v1::Distillation& distillation, FieldChecker& check) {
  check.Require(distillation.form() != v1::Distillation::FORM_UNSPECIFIED &&
                    v1::Distillation::Form_IsValid(distillation.form()),
                "distillation.form", "a known form",
                static_cast<int>(distillation.form()));
  CheckLearningRate(distillation, check);
  check.Positive(distillation.max_gradient_norm(),
                 "distillation.max_gradient_norm");
  check.AtLeast(distillation.inherited_rows(), 0,
                "distillation.inherited_rows");
  check.Positive(distillation.samples_per_insert(),
                 "distillation.samples_per_insert");
  check.Require(distillation.samples_per_insert() <= kMaxSamplesPerInsert,
                "distillation.samples_per_insert",
                absl::StrCat("<= ", kMaxSamplesPerInsert,
                             ", or one update would take hours"),
                distillation.samples_per_insert());
  check.AtLeast(distillation.kl_weight(), 0, "distillation.kl_weight");
  check.AtLeast(distillation.kl_weight_final(), 0,
                "distillation.kl_weight_final");
  CheckMarks(distillation.kl_anneal_begin(), distillation.kl_anneal_end(),
             "kl_anneal", check);
  check.AtLeast(distillation.continuity_weight(), 0,
                "distillation.continuity_weight");
}

// What else a recipe may ask for, and this learner cannot do.
void CheckExcluded(const v1::Recipe& recipe, FieldChecker& check) {
  constexpr absl::string_view kUnset = "unset, since distillation is set";
  constexpr absl::string_view kUnused =
      "unset, since ppo is unused where distillation is set";
  check.Require(!recipe.has_procedure(), "procedure", kUnset, "set");
  check.Require(!recipe.network().has_composer(), "network.composer", kUnset,
                "set");
  const v1::Ppo& ppo = recipe.ppo();
  check.Require(!ppo.mirror(), "ppo.mirror", kUnused, ppo.mirror());
  check.Require(
      !ppo.bfloat16(), "ppo.bfloat16",
      absl::StrCat(kUnused, " (distillation.bfloat16 is the student's)"),
      ppo.bfloat16());
  check.Require(ppo.kl_target() == 0, "ppo.kl_target", kUnused,
                ppo.kl_target());
  check.Require(ppo.value_warmup_iterations() == 0,
                "ppo.value_warmup_iterations", kUnused,
                ppo.value_warmup_iterations());
  check.Require(
      ppo.inherited_rows() == 0, "ppo.inherited_rows",
      absl::StrCat(kUnused, " (distillation.inherited_rows is the student's)"),
      ppo.inherited_rows());
  check.Require(ppo.anneal().begin_samples() == 0, "ppo.anneal.begin_samples",
                kUnused, ppo.anneal().begin_samples());
  check.Require(ppo.anneal().begin_iteration() == 0,
                "ppo.anneal.begin_iteration", kUnused,
                ppo.anneal().begin_iteration());
  check.Require(ppo.anneal().success_share() == 0, "ppo.anneal.success_share",
                kUnused, ppo.anneal().success_share());
  check.Require(ppo.anneal().stall_evaluations() == 0,
                "ppo.anneal.stall_evaluations", kUnused,
                ppo.anneal().stall_evaluations());
}

}  // namespace

void CheckAction(const v1::Action& action, const std::string& path,
                 FieldChecker& check) {
  check.Require(action.placement() != v1::Action::PLACEMENT_UNSPECIFIED &&
                    v1::Action::Placement_IsValid(action.placement()),
                path + ".placement", "a known placement",
                static_cast<int>(action.placement()));
  check.Positive(action.scale(), path + ".scale");
  check.AtLeast(action.strength_scale(), 0, path + ".strength_scale");
  check.Positive(action.clip(), path + ".clip");
  check.AtLeast(action.range_margin(), 0, path + ".range_margin");
  const bool around_reference =
      action.placement() == v1::Action::PLACEMENT_AROUND_NEXT_REFERENCE;
  const std::string only_around = absl::StrCat(
      "false unless ", path, ".placement is PLACEMENT_AROUND_NEXT_REFERENCE");
  check.Require(around_reference || !action.velocity_feedforward(),
                path + ".velocity_feedforward", only_around, true);
  check.Require(around_reference || !action.torque_feedforward(),
                path + ".torque_feedforward", only_around, true);
}

void CheckImitation(const v1::Recipe& recipe, FieldChecker& check) {
  if (recipe.network().has_latent()) CheckLatent(recipe, check);
  CheckLatentPpo(recipe, check);
  if (!recipe.has_distillation()) return;
  CheckExcluded(recipe, check);
  CheckTeacher(recipe, check);
  CheckShares(recipe, check);
  check.Within(recipe.distillation().action_noise(), 0, 100,
               "distillation.action_noise");
  CheckLosses(recipe.distillation(), check);
  CheckMinibatch(recipe, check);
  CheckMemory(recipe, check);
}

}  // namespace sinew
