#include "common/config/procedure_validate.h"

#include "common/config/layer_widths.h"
#include "common/config/recipe.h"

namespace sinew {
namespace {

// The recovery primitive comes on top of those that track.
constexpr int kMaxTracking = kMostPrimitives - 1;

bool EndsAtPlateau(const v1::Recipe& recipe) {
  return recipe.plateau().evaluations() > 0;
}

void CheckPlateau(const v1::Recipe& recipe, FieldChecker& check) {
  const v1::Plateau& plateau = recipe.plateau();
  check.AtLeast(plateau.evaluations(), 0, "plateau.evaluations");
  check.Within(plateau.gain(), 0, 1, "plateau.gain");
  check.AtLeast(plateau.min_samples(), 0, "plateau.min_samples");
  check.Require(!plateau.anneal() || plateau.evaluations() > 0,
                "plateau.anneal", "false, since plateau.evaluations is 0",
                plateau.anneal());
  check.Require(
      !plateau.anneal() || !recipe.has_distillation(), "plateau.anneal",
      "false, since a student's rate is distillation's own", plateau.anneal());
  check.Require(!EndsAtPlateau(recipe) || recipe.evaluation().interval() > 0,
                "evaluation.interval",
                ">= 1, since plateau waits for evaluations",
                recipe.evaluation().interval());
}

void CheckRecoveryStage(const v1::Recipe& recipe, FieldChecker& check) {
  const v1::Procedure& procedure = recipe.procedure();
  check.AtLeast(procedure.recovery_samples(), 0, "procedure.recovery_samples");
  const v1::Recovery& recovery = recipe.task().recovery();
  const double share = RecoveryShare(recovery);
  check.Require(procedure.recovery_samples() == 0 || share > 0, "task.recovery",
                "fallen_share + far_share + get_up_share > 0, since "
                "procedure.recovery_samples asks for a recovery primitive",
                share);
}

void CheckProcedure(const v1::Recipe& recipe, FieldChecker& check) {
  const v1::Procedure& procedure = recipe.procedure();
  check.Within(procedure.max_primitives(), 1, kMaxTracking,
               "procedure.max_primitives");
  check.AtLeast(procedure.negligible_clips(), 0, "procedure.negligible_clips");
  check.Within(procedure.learnable_share(), 0, 1, "procedure.learnable_share");
  check.Positive(procedure.full_samples(), "procedure.full_samples");
  check.Positive(procedure.hard_samples(), "procedure.hard_samples");
  check.AtLeast(procedure.composer_samples(), 0, "procedure.composer_samples");
  check.Require(procedure.composer_samples() == 0 ||
                    procedure.max_primitives() > 1 ||
                    procedure.recovery_samples() > 0,
                "procedure.composer_samples",
                "0, since one primitive alone cannot be composed",
                procedure.composer_samples());
  CheckLayerWidths(procedure.composer_hidden(), "procedure.composer_hidden",
                   check);
  check.Require(
      procedure.rehearsal_share() >= 0 && procedure.rehearsal_share() < 1,
      "procedure.rehearsal_share", "[0, 1)", procedure.rehearsal_share());
  check.Require(procedure.rehearsal_share() == 0 ||
                    recipe.task().start().only_clips().empty(),
                "procedure.rehearsal_share",
                "0, since it would rehearse clips that are not among "
                "task.start.only_clips",
                procedure.rehearsal_share());
  check.Within(procedure.environments_per_clip(), 0, kMostEnvironments,
               "procedure.environments_per_clip");
  check.Require(EndsAtPlateau(recipe), "plateau.evaluations",
                ">= 1, since stages of the procedure end at a plateau",
                recipe.plateau().evaluations());
  CheckRecoveryStage(recipe, check);
  check.Require(!recipe.network().has_composer(), "network.composer",
                "unset, since the procedure makes its composer itself", "set");
}

void CheckComposer(const v1::Composer& composer, FieldChecker& check) {
  check.Within(composer.primitives(), kFewestPrimitives, kMostPrimitives,
               "network.composer.primitives");
  CheckLayerWidths(composer.hidden(), "network.composer.hidden", check);
}

}  // namespace

void CheckStages(const v1::Recipe& recipe, FieldChecker& check) {
  if (recipe.has_plateau()) CheckPlateau(recipe, check);
  if (recipe.has_procedure()) CheckProcedure(recipe, check);
  if (recipe.network().has_composer()) {
    CheckComposer(recipe.network().composer(), check);
  }
}

}  // namespace sinew
