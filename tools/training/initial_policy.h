#ifndef SINEW_TOOLS_TRAINING_INITIAL_POLICY_H_
#define SINEW_TOOLS_TRAINING_INITIAL_POLICY_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/clock.h"
#include "common/policy/safetensors.h"
#include "learner/learner.h"
#include "learner/ppo/ppo_learner.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/run.pb.h"
#include "tools/training/task_setup.h"

namespace sinew::tools {

// Bundles (folders) that a run without states begins with.
struct InitialPolicy {
  std::string init;                     // its weights; empty: none
  std::vector<std::string> primitives;  // what a composer weighs
  // Weights of a value network that comes with `init`; empty: none, the run's
  // own starts untrained.
  TensorMap critic = {};
};

// The value network's weights of the newest training state in a run's folder
// checkpoints/; bundles have none. Blocks on the disk. Errors: those of
// LoadLatestState; DATA_LOSS if that state (an older one, where the newest is
// damaged) is not of `iteration` or has no critic.
absl::StatusOr<TensorMap> ReadCritic(const std::string& checkpoints,
                                     int64_t iteration, const Clock& clock);

// Puts the bundles' weights into the learner, made for this recipe (defaults
// filled) and task. Every bundle must be of the same character, joints in the
// same order, observe the same, and act by the same law at the same control
// rate; a primitive must also have the network that the recipe describes
// (policy_hidden, activation, observation_clip), and be no composer; `init` has
// the network of the run. Whether a bundle explores does not matter: students,
// which do not, begin runs of PPO and the other way round. A recipe with a
// composer needs as many primitives as it says, or `init`.
//
// Thread-safety: one caller. Ownership: none. Blocking: reads the bundles.
// Errors: INVALID_ARGUMENT naming bundle and field, expected and found, or
// what ReadBundle says; the learner is then as it was.
absl::Status BeginWith(const InitialPolicy& policy, const v1::Recipe& recipe,
                       const TaskSetup& setup, learner::PpoLearner& learner);

// The same for a learner that weighs no primitives.
absl::Status BeginWithInit(const InitialPolicy& policy,
                           const v1::Recipe& recipe, const TaskSetup& setup,
                           learner::Learner& learner);

// What a run's bundles are to say of these. Blocks on the disk. Errors: those
// of ReadBundle.
absl::StatusOr<std::vector<v1::RunInputs::Source>> InitialSources(
    const InitialPolicy& policy);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_INITIAL_POLICY_H_
