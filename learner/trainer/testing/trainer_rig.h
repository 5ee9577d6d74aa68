#ifndef SINEW_LEARNER_TRAINER_TESTING_TRAINER_RIG_H_
#define SINEW_LEARNER_TRAINER_TESTING_TRAINER_RIG_H_

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/config/recipe.h"
#include "common/digest.h"
#include "common/policy/safetensors.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "google/protobuf/text_format.h"
#include "gtest/gtest.h"
#include "learner/ppo/ppo_learner.h"
#include "learner/ppo/synthetic_segments.h"
#include "learner/trainer/testing/fake_experience.h"
#include "learner/trainer/trainer.h"
#include "proto/sinew/v1/motion.pb.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew::learner {

// What tests of the trainer share.

inline const SyntheticProblem kProblem;

// 2 orders of 4 environments, 8 steps; evaluations of 3 starts at every second
// iteration.
inline v1::Recipe MakeRecipe(const std::string& overrides = "") {
  v1::Recipe recipe;
  const std::string text = absl::StrCat(
      R"pb(
        format_version: 1
        name: "fake"
        seed: 7
        network {
          policy_hidden: [ 8 ]
          value_hidden: [ 8 ]
          initial_std: 0.3
        }
        rollouts { environments: 8 horizon: 8 environments_per_order: 4 }
        ppo {
          minibatch: 32
          anneal { success_share: 1 samples: 1000 std_factor: 0.5 }
        }
        evaluation { interval: 2 starts: 3 seconds: 1 }
      )pb",
      overrides);
  EXPECT_TRUE(google::protobuf::TextFormat::MergeFromString(text, &recipe));
  return WithDefaults(recipe);
}

inline constexpr char kLagOne[] =
    "rollouts { max_policy_lag: 1 } evaluation { delay: 2 }";

inline v1::MotionLibrary MakeLibrary() {
  v1::MotionLibrary library;
  library.set_frames_per_second(30);
  v1::ClipInfo& clip = *library.add_clips();
  clip.set_name("walk");
  clip.set_num_frames(40);
  clip.set_loops(true);
  return library;
}

// A trainer with its experience.
struct Rig {
  explicit Rig(const v1::Recipe& recipe, int ranks = 1,
               const std::string& assets = "assets",
               const v1::MotionLibrary& library = MakeLibrary(),
               const std::vector<std::string>& clip_sha256 = {})
      : experience(kProblem) {
    // Evaluations succeed once the third snapshot acts.
    experience.success_version = 3;
    auto learner = PpoLearner::Create(
        recipe,
        {.observation_width = static_cast<int>(kProblem.observation_width),
         .action_width = static_cast<int>(kProblem.action_width),
         .ranks = ranks});
    EXPECT_THAT(learner, sinew::testing::IsOk());
    auto created = Trainer::Create({.recipe = recipe,
                                    .library = library,
                                    .clip_sha256 = clip_sha256,
                                    .run_id = MakeRunId(recipe, assets),
                                    .assets_sha256 = assets,
                                    .layout_sha256 = "layout"},
                                   *std::move(learner), experience);
    EXPECT_THAT(created, sinew::testing::IsOk());
    trainer = *std::move(created);
  }

  IterationReport Iterate(int times = 1) {
    IterationReport report;
    for (int i = 0; i < times; ++i) {
      auto result = trainer->RunIteration();
      EXPECT_THAT(result, sinew::testing::IsOk());
      if (result.ok()) report = *std::move(result);
    }
    return report;
  }

  FakeExperience experience;
  std::unique_ptr<Trainer> trainer;
};

// Digest of all bits of a state.
inline std::string Bits(const Trainer::State& state) {
  std::string all = SerializeDeterministically(state.counters) +
                    SerializeSafetensors(state.tensors);
  for (const std::string& bytes : state.snapshots) all += Sha256Hex(bytes);
  for (const StateChunk& chunk : state.chunks) all += Sha256Hex(*chunk.bytes);
  return Sha256Hex(all);
}

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_TRAINER_TESTING_TRAINER_RIG_H_
