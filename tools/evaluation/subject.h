#ifndef SINEW_TOOLS_EVALUATION_SUBJECT_H_
#define SINEW_TOOLS_EVALUATION_SUBJECT_H_

#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "actor/prepared_snapshot.h"
#include "actor/rollout_assets.h"
#include "common/policy/safetensors.h"
#include "proto/sinew/v1/graph.pb.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "sim/character/character.h"
#include "sim/motion/library.h"
#include "sim/world/fallen_states.h"

namespace sinew::evaluation {

// What is looked at: a policy on a library of clips, and the zero action on
// the same task beside it. Immutable parts, shared.
struct Subject {
  std::shared_ptr<const actor::RolloutAssets> assets;
  std::shared_ptr<const actor::PreparedSnapshot> policy;
  std::shared_ptr<const actor::PreparedSnapshot> zero_action;

  const motion::Library& library() const { return assets->task().library(); }
  const character::Character& character() const {
    return assets->task().character();
  }
};

// Names of the tracked bodies, in the order of errors per body.
std::vector<std::string> TrackedBodyNames(const Subject& subject);

// Index of the clip with this name; of the first one for an empty name.
// NOT_FOUND lists the nearest name or the first few there are.
absl::StatusOr<int> FindClip(const motion::Library& library,
                             const std::string& name);

// A graph "policy" with its weights. `recipe` has its defaults filled; only
// physics, task and evaluation matter. `fallen`: what EvaluateFallen starts
// from (fallen_figures.h), or none. Blocking: computes (packing).
// INVALID_ARGUMENT names what does not fit: rates, character, joints, widths.
absl::StatusOr<Subject> MakeSubject(
    const v1::Recipe& recipe,
    std::unique_ptr<const character::Character> character,
    std::unique_ptr<const motion::Library> library,
    const v1::PolicyGraph& graph, const TensorMap& weights,
    std::unique_ptr<const world::FallenStates> fallen = nullptr);

// The zero action as policy: what the task is worth before any training.
absl::StatusOr<Subject> MakeZeroActionSubject(
    const v1::Recipe& recipe,
    std::unique_ptr<const character::Character> character,
    std::unique_ptr<const motion::Library> library,
    std::unique_ptr<const world::FallenStates> fallen = nullptr);

}  // namespace sinew::evaluation

#endif  // SINEW_TOOLS_EVALUATION_SUBJECT_H_
