#include "tools/evaluation/fallen_figures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/types/span.h"
#include "actor/fallen_evaluation.h"
#include "common/config/recipe.h"
#include "common/files.h"
#include "common/stop.h"
#include "common/testing/matchers.h"
#include "sim/world/fallen_states.h"
#include "sim/world/testing/toy_world.h"
#include "tools/evaluation/bundle_subject.h"
#include "tools/evaluation/evaluate_bundle.h"
#include "tools/evaluation/evaluation_json.h"
#include "tools/evaluation/rollout_pool.h"
#include "tools/evaluation/testing/written_bundle.h"

namespace sinew::evaluation {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;
using Json = nlohmann::json;

std::string CharacterFile(const world::testing::ToyWorld& toy) {
  return JoinPath(toy.folder, "character.textproto");
}

v1::Recipe RecoveryRecipe(int steps) {
  v1::Recipe recipe = world::testing::ToyRecipe();
  v1::Recovery* recovery = recipe.mutable_task()->mutable_recovery();
  recovery->set_fallen_share(0.5);
  recovery->set_steps(steps);
  recovery->set_fallen_states(2);
  recovery->set_fallen_seed(9);
  return WithDefaults(recipe);
}

absl::StatusOr<Subject> ZeroActionOf(const v1::Recipe& recipe, int states,
                                     std::initializer_list<int> left_out = {}) {
  world::testing::ToyWorld toy = world::testing::MakeToyWorld(recipe);
  LeaveOut(left_out, toy);
  auto fallen = MakeFallenStates(CharacterFile(toy), states);
  if (!fallen.ok()) return fallen.status();
  return MakeZeroActionSubject(toy.recipe, std::move(toy.character),
                               std::move(toy.library), *std::move(fallen));
}

// The zero action on the toy, where who is `distance` m off still tracks.
absl::StatusOr<Subject> ZeroAction(int states, double distance,
                                   std::initializer_list<int> left_out = {}) {
  v1::Recipe recipe = world::testing::ToyRecipe();
  recipe.mutable_evaluation()->set_max_mean_body_distance(distance);
  return ZeroActionOf(recipe, states, left_out);
}

class FallenBundle : public testing::WrittenBundle {
 protected:
  absl::StatusOr<EvaluationFigures> Evaluate(std::optional<int> fallen) const {
    return EvaluateBundle(
        bundle_, motions_, out_,
        {.starts = 1, .seconds = 0.5, .threads = 2, .fallen = fallen},
        StopToken());
  }
};

TEST_F(FallenBundle, IsMeasuredWithoutRecoveryInItsRecipe) {
  Write();

  const auto figures = Evaluate(4);

  ASSERT_THAT(figures, IsOk());
  ASSERT_TRUE(figures->fallen.has_value());
  const Json fallen = Json::parse(*ReadFile(out_))["fallen"];
  EXPECT_EQ(fallen["starts"], 4);
  EXPECT_EQ(fallen["seed"], world::FallenStates::kEvaluationSeed);
  EXPECT_EQ(fallen["clips"], 1);  // "turn": the others are too short
  EXPECT_EQ(fallen["seconds"], 5.5);
  EXPECT_EQ(fallen["reference_stands_seconds"], 3);
  EXPECT_EQ(fallen["recovered_3_s"], figures->fallen->policy.recovered_3_s);
  EXPECT_EQ(fallen["zero_action"]["recovered_5_s"],
            figures->fallen->zero_action.recovered_5_s);
  EXPECT_LE(fallen["recovered_3_s"], fallen["recovered_5_s"]);
  EXPECT_FALSE(fallen.contains("get_up"));  // the library has none
}

TEST_F(FallenBundle, IsMeasuredForAsLongAsItsRecipeSaysOnBodiesThatAreNotIts) {
  Write(RecoveryRecipe(/*steps=*/60));

  ASSERT_THAT(Evaluate(3), IsOk());  // more than the recipe trains on

  const Json fallen = Json::parse(*ReadFile(out_))["fallen"];
  EXPECT_EQ(fallen["starts"], 3);
  EXPECT_EQ(fallen["seed"], world::FallenStates::kEvaluationSeed);
  EXPECT_EQ(fallen["reference_stands_seconds"], 2);
}

TEST_F(FallenBundle, IsMeasuredOnGetUpsTooWhereThereAreAny) {
  Write(world::testing::ToyRecipe(), world::testing::ToyClips::kWithGetUp);

  const auto figures = Evaluate(4);

  ASSERT_THAT(figures, IsOk());
  ASSERT_TRUE(figures->fallen && figures->fallen->get_up);
  const FallenEvaluation::GetUp& get_up = *figures->fallen->get_up;
  const Json json = Json::parse(*ReadFile(out_))["fallen"]["get_up"];
  EXPECT_NEAR(json["reference_stands_seconds"], 2.0 / 3, 1e-9);
  EXPECT_EQ(json["recovered_3_s"], get_up.policy.recovered_3_s);
  ASSERT_EQ(json["rows"].size(), get_up.policy.rows.size());
  EXPECT_EQ(json["rows"][0]["clip"], "sway");
  EXPECT_EQ(json["rows"][0]["state"], 0);
  EXPECT_EQ(json["rows"][0]["seconds"], get_up.policy.rows[0].seconds);
  EXPECT_EQ(json["recovered_5_s"], get_up.policy.recovered_5_s);
  EXPECT_EQ(json["zero_action"]["recovered_5_s"],
            get_up.zero_action.recovered_5_s);
}

TEST_F(FallenBundle, IsNotMeasuredUnlessAskedFor) {
  Write();

  const auto figures = Evaluate(std::nullopt);

  ASSERT_THAT(figures, IsOk());
  EXPECT_FALSE(figures->fallen.has_value());
  EXPECT_FALSE(Json::parse(*ReadFile(out_)).contains("fallen"));
}

TEST_F(FallenBundle, GivesTheSameBytesWithAnyNumberOfThreads) {
  Write();
  const auto loaded = LoadBundleSubject(bundle_, motions_, 10);
  ASSERT_THAT(loaded, IsOk());
  const auto json = [&](int threads) {
    Evaluation evaluation;
    auto fallen = EvaluateFallen(loaded->subject, threads, StopToken());
    EXPECT_THAT(fallen, IsOk());
    evaluation.fallen = *fallen;
    return EvaluationJson(loaded->subject, {}, {}, evaluation);
  };

  const std::string one = json(1);

  EXPECT_THAT(one, HasSubstr("recovered_5_s"));
  EXPECT_EQ(json(3), one);
}

TEST_F(FallenBundle, RefusesNumbersOfStartsThatMakeNoSense) {
  Write();
  for (const int starts : {-1, 0, kMostFallenStarts + 1}) {
    EXPECT_THAT(
        Evaluate(starts),
        StatusIs(absl::StatusCode::kInvalidArgument,
                 HasSubstr(absl::StrCat("fallen starts: expected 1 to 1024, "
                                        "found ",
                                        starts))));
  }
  EXPECT_FALSE(FileExists(out_));
}

TEST(FallenFigures, CountWhoIsUpWithinThreeSecondsAndWhoWithinFive) {
  std::vector<v1::EvaluationResult> results(5);
  const int frames[] = {90, 91, 150, 151, -1};
  for (int i = 0; i < 5; ++i) {
    results[i].set_fallen_state(i);
    results[i].set_recovered_at_frame(frames[i]);
  }

  results[1].add_carried()->set_after_frames(60);
  results[2].set_clip(7);
  results[2].set_frames(165);
  std::swap(results[0], results[3]);

  const FallenFigures figures = FiguresOf(results, /*control_hz=*/30);

  EXPECT_DOUBLE_EQ(figures.recovered_3_s, 0.2);
  EXPECT_DOUBLE_EQ(figures.recovered_5_s, 0.6);
  ASSERT_EQ(figures.rows.size(), 5);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(figures.rows[i].state, i);
  EXPECT_EQ(figures.rows[0].recovered_s, 3);
  EXPECT_EQ(figures.rows[0].carried_s, std::nullopt);
  EXPECT_EQ(figures.rows[1].carried_s, 2);
  EXPECT_EQ(figures.rows[2].clip, 7);
  EXPECT_EQ(figures.rows[2].seconds, 5.5);
  EXPECT_EQ(figures.rows[4].recovered_s, std::nullopt);
}

TEST(FallenFigures, AreOverAllClipsThatAreFit) {
  // 19 frames are tracked: of "turn" and "sway", but "tumble" is too short.
  const auto subject = ZeroActionOf(RecoveryRecipe(/*steps=*/146), 4);
  ASSERT_THAT(subject, IsOk());

  const auto fallen = EvaluateFallen(*subject, /*threads=*/1, StopToken());

  ASSERT_THAT(fallen, IsOk());
  EXPECT_EQ(fallen->starts, 4);
  EXPECT_EQ(fallen->clips, 2);
}

TEST(FallenFigures, AreThoseOfEachStartOnItsOwn) {
  const auto subject = ZeroAction(/*states=*/10, /*distance=*/5);
  ASSERT_THAT(subject, IsOk());
  const auto starts = actor::FallenStarts(subject->assets->task(), 5);
  ASSERT_THAT(starts, IsOk());
  std::vector<v1::EvaluationResult> results;
  for (const v1::EvaluationStart& start : *starts) {
    const auto result = RunStarts(subject->assets, *subject->policy, {start},
                                  /*threads=*/1, StopToken());
    ASSERT_THAT(result, IsOk());
    results.push_back(result->front());
  }

  const auto fallen = EvaluateFallen(*subject, /*threads=*/2, StopToken());

  ASSERT_THAT(fallen, IsOk());
  EXPECT_EQ(fallen->policy.recovered_3_s,
            actor::RecoveredShare(results, 3, 30));
  EXPECT_EQ(fallen->policy.recovered_5_s,
            actor::RecoveredShare(results, 5, 30));
  EXPECT_EQ(fallen->zero_action.recovered_5_s, fallen->policy.recovered_5_s);
}

TEST(FallenFigures, AreZeroWhereNobodyTracks) {
  const auto subject = ZeroAction(/*states=*/4, /*distance=*/1e-6);
  ASSERT_THAT(subject, IsOk());

  const auto fallen = EvaluateFallen(*subject, /*threads=*/1, StopToken());

  ASSERT_THAT(fallen, IsOk());
  EXPECT_EQ(fallen->starts, 4);
  EXPECT_EQ(fallen->policy.recovered_5_s, 0);
}

TEST(FallenFigures, NeedAClipThatIsFitForIt) {
  const auto subject = ZeroAction(/*states=*/1, /*distance=*/0.5, {0});
  ASSERT_THAT(subject, IsOk());

  EXPECT_THAT(EvaluateFallen(*subject, /*threads=*/1, StopToken()),
              StatusIs(absl::StatusCode::kNotFound,
                       HasSubstr("expected a clip of at least 76 frames")));
}

TEST(FallenFigures, StopWhenAsked) {
  const auto subject = ZeroAction(/*states=*/1, /*distance=*/0.5);
  ASSERT_THAT(subject, IsOk());
  StopSource source;
  source.request_stop();

  EXPECT_THAT(EvaluateFallen(*subject, /*threads=*/1, source.get_token()),
              StatusIs(absl::StatusCode::kCancelled));
}

}  // namespace
}  // namespace sinew::evaluation
