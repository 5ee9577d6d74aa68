#ifndef SINEW_COMMON_CONFIG_RECIPE_H_
#define SINEW_COMMON_CONFIG_RECIPE_H_

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew {

// From text to a recipe that may be run:
//
//   ParseRecipe -> SetRecipeField* -> WithDefaults -> ValidateRecipe
//
// Everything here is pure and thread-safe; nothing blocks.

// Parses a recipe from text proto. INVALID_ARGUMENT names the file, line and
// field (text_proto.h).
absl::StatusOr<v1::Recipe> ParseRecipe(absl::string_view text,
                                       absl::string_view source);

// Applies `--set path=value`: "ppo.epochs=3", "task.action.ramp=true",
// "network.policy_hidden=[512,256]", "task.start.rule=bins" (or RULE_BINS). An
// empty list "[]" unsets. Unknown path or unparsable value: INVALID_ARGUMENT
// naming it and what is known there; the recipe stays as it was.
absl::Status SetRecipeField(v1::Recipe& recipe, absl::string_view assignment);

// Fills unset fields with the defaults documented in recipe.proto. Changes
// nothing the second time.
v1::Recipe WithDefaults(v1::Recipe recipe);

// The same for these fields alone.
v1::AdaptiveBins WithDefaults(v1::AdaptiveBins adaptive);

// Checks a recipe whose defaults are filled: every range, that sizes divide,
// and that it cannot deadlock (lag against evaluation delay; the bytes of one
// iteration against the replay bound are checked by the learner once widths
// are known). INVALID_ARGUMENT for the first violation: "recipe field PATH:
// expected WHAT, found VALUE".
absl::Status ValidateRecipe(const v1::Recipe& recipe);

// Primitives that a composer may have, a procedure's among them.
inline constexpr int kFewestPrimitives = 2;
inline constexpr int kMostPrimitives = 16;
// Bound of rollouts.environments.
inline constexpr int kMostEnvironments = 1 << 20;

// Share of episodes that begin off their reference; recovery is on where it is
// not 0.
double RecoveryShare(const v1::Recovery& recovery);

// Recovery.get_up_steps where nothing is said.
inline constexpr int kGetUpSteps = 20;

// Share of episodes that begin in a state of the asset "fallen".
double FallenShare(const v1::Recovery& recovery);

// Whether a block of observations is about the body alone: it needs no
// reference.
bool IsSelfBlock(int block);
// How many of these an observation (defaults filled) begins with. The columns
// of these are what prior and decoder of a latent see; how many columns that
// is: ObservationBuilder::self_width() (sim/world/observation.h).
int LeadingSelfBlocks(const v1::Observation& observation);

// Width of the latent (defaults filled) that PPO learns, whose noise segments
// record (common/segment/segment_layout.h); 0: there is none, or it is
// distilled.
int RecordedLatentWidth(const v1::Recipe& recipe);

// Whether actions are placed without a reference, as those of a decoder are.
bool IsBlindPlacement(v1::Action::Placement placement);

// Canonical text, as in config.textproto: fields in the order of their
// numbers, those at zero or unset left out. ParseRecipe gives the same recipe.
std::string PrintRecipe(const v1::Recipe& recipe);

}  // namespace sinew

#endif  // SINEW_COMMON_CONFIG_RECIPE_H_
