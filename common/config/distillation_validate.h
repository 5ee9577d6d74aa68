#ifndef SINEW_COMMON_CONFIG_DISTILLATION_VALIDATE_H_
#define SINEW_COMMON_CONFIG_DISTILLATION_VALIDATE_H_

#include <string>

#include "common/config/field_checker.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew {

// The parts of ValidateRecipe (recipe.h) that look at action laws, and at what
// is learnt from a teacher: distillation and latent. Thread-safety: pure.
// Blocking: never. Errors: in `check`.

// `path` is the law's, e.g. "task.action".
void CheckAction(const v1::Action& action, const std::string& path,
                 FieldChecker& check);

// Beyond ranges:
//   latent         no composer; the body's own blocks before those of the goal,
//                  one of each at least; an action law without reference. Where
//                  PPO learns it: neither mirror images nor a procedure; and
//                  elsewhere no weight of its KL
//   distillation   neither procedure nor composer; of `ppo`, which is unused,
//                  nothing that would have to change what is done: mirror,
//                  anneal, kl_target, bfloat16. The teacher's targets must
//                  mean to the student's body what they meant to its own
//                  (ramp) and be within its reach (range_margin); an update
//                  ends (samples_per_insert at most 1024)
void CheckImitation(const v1::Recipe& recipe, FieldChecker& check);

}  // namespace sinew

#endif  // SINEW_COMMON_CONFIG_DISTILLATION_VALIDATE_H_
