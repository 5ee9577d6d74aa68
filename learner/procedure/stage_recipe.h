#ifndef SINEW_LEARNER_PROCEDURE_STAGE_RECIPE_H_
#define SINEW_LEARNER_PROCEDURE_STAGE_RECIPE_H_

#include "absl/status/status.h"
#include "learner/procedure/procedure.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew::learner {

// The recipe of one stage, the `index`-th from 0: that of the procedure, but
//
//   procedure, max_minutes  unset
//   max_iterations          the stage's samples, rounded up to iterations
//                           (kSingle has its own, others the procedure's)
//   seed                    another one for each stage; the first has the
//                           procedure's, so it is the run of the same recipe
//   name                    NAME_STAGE, if there is one
//   rollouts.environments, ppo.minibatch, rollouts.replay_bytes   in kHard and
//                           kGrown larger, by the procedure's
//                           environments_per_clip; evaluation.interval and
//                           checkpointing.interval are as many times smaller
//   start.only_clips        the stage's clips, if it has some
//   task.recovery           in kRecovery and kComposer only, and only if there
//                           is a recovery primitive; no width changes
//   start.other_clips_share the procedure's rehearsal_share in kHard, 0 in
//                           kGrown
//   plateau, ppo.anneal     where task.recovery is on, evaluations neither end
//                           the stage nor begin its annealing: they start on
//                           the reference and say nothing of getting up; nor
//                           in kSingle, which is to take all of its samples
//   ppo.anneal.begin_iteration   as many iterations as have anneal.samples
//                           before the stage's last one (from the first on in a
//                           stage no longer than that), if annealing changes
//                           anything, so that the weights that count have
//                           settled
//   ppo.value_warmup_iterations   not in kHard, kGrown and kSingle: their value
//                           networks have learnt
//   network.composer        in kComposer only
//
// `recipe` has its defaults filled and is valid, then so is the result. Pure.
v1::Recipe StageRecipe(const v1::Recipe& recipe, const Stage& stage, int index);

// Checks the recipes of all kinds of stages that there may be, so that nothing
// is found out after hours that could be found out at the start.
// INVALID_ARGUMENT names the kind of stage and the field.
absl::Status ValidateStages(const v1::Recipe& recipe);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_PROCEDURE_STAGE_RECIPE_H_
