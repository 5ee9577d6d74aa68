#ifndef SINEW_COMMON_CONFIG_RECIPE_H_
#define SINEW_COMMON_CONFIG_RECIPE_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew {

// Parses a recipe from text proto. Errors name the file, line and field.
absl::StatusOr<v1::Recipe> ParseRecipe(absl::string_view text,
                                       absl::string_view source);

// Applies `--set path=value`, e.g. "ppo.epochs=3",
// "network.policy_hidden=[512,256]", "task.action.ramp=true". Unknown path or
// unparsable value: INVALID_ARGUMENT naming it and the nearest known field.
absl::Status SetRecipeField(v1::Recipe& recipe, absl::string_view assignment);

// Fills unset fields with the defaults documented in recipe.proto.
v1::Recipe WithDefaults(v1::Recipe recipe);

// Checks a recipe whose defaults are filled: ranges, divisibility, and that it
// cannot deadlock (lag, evaluation delay, bytes of one iteration against the
// replay bound are checked by the learner once widths are known).
absl::Status ValidateRecipe(const v1::Recipe& recipe);

// Canonical text (all fields set, stable order), as config.textproto.
std::string PrintRecipe(const v1::Recipe& recipe);

}  // namespace sinew

#endif  // SINEW_COMMON_CONFIG_RECIPE_H_
