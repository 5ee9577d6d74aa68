#ifndef SINEW_LEARNER_PPO_TESTING_PPO_RIG_H_
#define SINEW_LEARNER_PPO_TESTING_PPO_RIG_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/digest.h"
#include "common/policy/safetensors.h"
#include "common/segment/mirror.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "google/protobuf/text_format.h"
#include "gtest/gtest.h"
#include "learner/ppo/ppo_learner.h"
#include "learner/ppo/synthetic_segments.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "proto/sinew/v1/training_state.pb.h"

namespace sinew::learner {

// What tests of the learner share: a synthetic problem, which one update after
// another solves.

// Small networks and eager steps, on 8 orders x 8 environments x 32 steps.
inline v1::Recipe MakeRecipe(const std::string& overrides = "") {
  v1::Recipe recipe;
  const std::string text =
      R"pb(
        format_version: 1
        name: "synthetic"
        seed: 7
        network {
          policy_hidden: [ 32, 32 ]
          value_hidden: [ 32, 32 ]
          initial_std: 0.3
        }
        rollouts { environments: 64 horizon: 32 environments_per_order: 8 }
        ppo {
          discount: 0.1
          epochs: 3
          minibatch: 512
          shards: 2
          policy_learning_rate: 3e-3
          value_learning_rate: 3e-3
        }
      )pb" +
      overrides;
  EXPECT_TRUE(google::protobuf::TextFormat::MergeFromString(text, &recipe));
  return recipe;
}

// Where there is a latent, the body's own state is all but two columns of the
// observation.
inline std::unique_ptr<PpoLearner> MakeLearner(
    const v1::Recipe& recipe, int ranks = 2,
    std::optional<SegmentMirror> mirror = std::nullopt) {
  const SyntheticProblem problem;
  auto learner = PpoLearner::Create(
      recipe, {.observation_width = static_cast<int>(problem.observation_width),
               .self_observation_width =
                   static_cast<int>(problem.observation_width) - 2,
               .action_width = static_cast<int>(problem.action_width),
               .ranks = ranks,
               .mirror = std::move(mirror)});
  EXPECT_THAT(learner.status(), sinew::testing::IsOk());
  return *std::move(learner);
}

inline std::vector<v1::Segment> Collect(const PpoLearner& learner,
                                        int64_t iteration,
                                        const SyntheticProblem& problem = {}) {
  return MakeSyntheticSegments(problem, learner.graph(), learner.weights(),
                               iteration);
}

inline UpdateStatistics UpdateOnce(PpoLearner& learner, int64_t iteration,
                                   const SyntheticProblem& problem = {}) {
  const std::vector<v1::Segment> segments =
      Collect(learner, iteration, problem);
  auto statistics = learner.Update(Pointers(segments), iteration);
  EXPECT_THAT(statistics.status(), sinew::testing::IsOk());
  return *statistics;
}

// Digest of all bits of a learner.
inline std::string Bits(const PpoLearner& learner) {
  v1::TrainingState state;
  learner.SaveCounters(state);
  return Sha256Hex(SerializeSafetensors(learner.SaveTensors()) +
                   state.SerializeAsString());
}

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_PPO_TESTING_PPO_RIG_H_
