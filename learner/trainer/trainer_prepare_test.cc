// What a trainer does where a learner must ask others before it learns.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>

#include "common/testing/matchers.h"
#include "learner/learner.h"
#include "learner/ppo/ppo_learner.h"
#include "learner/trainer/testing/fake_experience.h"
#include "learner/trainer/testing/trainer_rig.h"
#include "learner/trainer/trainer.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

// PPO behind somebody who has to be asked.
class AskingLearner : public Learner {
 public:
  explicit AskingLearner(std::unique_ptr<PpoLearner> ppo)
      : ppo_(std::move(ppo)) {}

  absl::Status Prepare(
      absl::Span<const v1::Segment* const> /*segments*/) override {
    return answer;
  }
  absl::StatusOr<UpdateStatistics> Update(
      absl::Span<const v1::Segment* const> segments,
      int64_t iteration) override {
    return ppo_->Update(segments, iteration);
  }
  const v1::PolicyGraph& graph() const override { return ppo_->graph(); }
  TensorMap weights() const override { return ppo_->weights(); }
  TensorMap SaveTensors() const override { return ppo_->SaveTensors(); }
  void SaveCounters(v1::TrainingState& state) const override {
    ppo_->SaveCounters(state);
  }
  absl::Status Load(const TensorMap& tensors, const v1::TrainingState& state,
                    absl::Span<const StateChunk> chunks) override {
    return ppo_->Load(tensors, state, chunks);
  }
  absl::Status InitFrom(const TensorMap& weights) override {
    return ppo_->InitFrom(weights);
  }
  void SetFactors(double std_factor, double learning_rate_factor) override {
    ppo_->SetFactors(std_factor, learning_rate_factor);
  }

  absl::Status answer;

 private:
  const std::unique_ptr<PpoLearner> ppo_;
};

// A trainer with such a learner.
struct AskingRig {
  explicit AskingRig(const v1::Recipe& recipe) : experience(kProblem) {
    auto ppo = PpoLearner::Create(
        recipe,
        {.observation_width = static_cast<int>(kProblem.observation_width),
         .action_width = static_cast<int>(kProblem.action_width)});
    EXPECT_THAT(ppo, IsOk());
    auto asking = std::make_unique<AskingLearner>(*std::move(ppo));
    learner = asking.get();
    auto created = Trainer::Create({.recipe = recipe,
                                    .library = MakeLibrary(),
                                    .run_id = MakeRunId(recipe, "assets"),
                                    .assets_sha256 = "assets",
                                    .layout_sha256 = "layout"},
                                   std::move(asking), experience);
    EXPECT_THAT(created, IsOk());
    trainer = *std::move(created);
  }

  FakeExperience experience;
  AskingLearner* learner = nullptr;
  std::unique_ptr<Trainer> trainer;
};

class TrainerPrepare : public ::testing::TestWithParam<const char*> {};

TEST_P(TrainerPrepare, CanBeSavedAndGoneOnFromWhereNobodyAnswered) {
  const v1::Recipe recipe = MakeRecipe(GetParam());
  AskingRig failing(recipe);
  ASSERT_THAT(failing.trainer->RunIteration(), IsOk());
  failing.learner->answer = absl::UnavailableError("teacher a:1: refused");

  EXPECT_THAT(failing.trainer->RunIteration().status(),
              StatusIs(absl::StatusCode::kUnavailable, HasSubstr("a:1")));

  ASSERT_TRUE(failing.trainer->at_rest());
  EXPECT_EQ(failing.trainer->iteration(), 1);
  AskingRig resumed(recipe);
  ASSERT_THAT(resumed.trainer->Restore(failing.trainer->Save()), IsOk());
  AskingRig straight(recipe);
  ASSERT_THAT(straight.trainer->RunIteration(), IsOk());
  for (AskingRig* rig : {&resumed, &straight}) {
    ASSERT_THAT(rig->trainer->RunIteration(), IsOk());
    ASSERT_THAT(rig->trainer->RunIteration(), IsOk());
  }
  EXPECT_EQ(Bits(resumed.trainer->Save()), Bits(straight.trainer->Save()));
}

INSTANTIATE_TEST_SUITE_P(Lags, TrainerPrepare, ::testing::Values("", kLagOne),
                         [](const auto& lag) {
                           return *lag.param == '\0' ? "None" : "One";
                         });

}  // namespace
}  // namespace sinew::learner
