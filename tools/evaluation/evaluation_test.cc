#include "tools/evaluation/evaluation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "common/check.h"
#include "common/policy/builder.h"
#include "common/testing/matchers.h"
#include "proto/sinew/v1/bundle.pb.h"
#include "sim/world/testing/toy_world.h"
#include "tools/evaluation/evaluation_json.h"
#include "tools/evaluation/recording.h"
#include "tools/evaluation/rollout_pool.h"

namespace sinew::evaluation {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::DoubleNear;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pointwise;
using Json = nlohmann::json;

// A small random policy on the toy's three clips ("turn" loops).
Subject RandomSubject(double gain = 0.3) {
  world::testing::ToyWorld toy = world::testing::MakeToyWorld();
  auto probe = MakeZeroActionSubject(toy.recipe, std::move(toy.character),
                                     std::move(toy.library));
  SINEW_CHECK(probe.ok()) << probe.status().ToString();
  policy::TrackingPolicyOptions options;
  options.observation_width = probe->assets->task().observation_width();
  options.action_width = probe->assets->task().action_width();
  options.network = toy.recipe.network();
  options.network.clear_policy_hidden();
  options.network.add_policy_hidden(16);
  options.network.set_last_layer_gain(gain);
  toy = world::testing::MakeToyWorld();
  auto subject =
      MakeSubject(toy.recipe, std::move(toy.character), std::move(toy.library),
                  *policy::BuildTrackingPolicy(options),
                  *policy::InitialWeights(options, /*seed=*/3));
  SINEW_CHECK(subject.ok()) << subject.status().ToString();
  return *std::move(subject);
}

std::string JsonWith(const Subject& subject, EvaluationOptions options) {
  auto evaluation = Evaluate(subject, options, StopToken());
  SINEW_CHECK(evaluation.ok()) << evaluation.status().ToString();
  return EvaluationJson(subject, options,
                        {.bundle = "b", .manifest_sha256 = "m", .motions = "l"},
                        *evaluation);
}

TEST(Evaluation, GivesTheSameBytesWithAnyNumberOfThreads) {
  const Subject subject = RandomSubject();

  const std::string one =
      JsonWith(subject, {.starts = 10, .seconds = 2, .threads = 1});
  const std::string four =
      JsonWith(subject, {.starts = 10, .seconds = 2, .threads = 4});

  EXPECT_EQ(one, four);
}

TEST(Evaluation, OfThePolicyAloneIsThePolicysPart) {
  const Subject subject = RandomSubject();
  const EvaluationOptions options = {.starts = 2, .seconds = 0.5};
  const auto both = Evaluate(subject, options, StopToken());
  ASSERT_THAT(both, IsOk());

  const auto alone = EvaluatePolicy(subject, options, StopToken());

  ASSERT_THAT(alone, IsOk());
  EXPECT_EQ(alone->overall.frames, both->policy.overall.frames);
  EXPECT_EQ(alone->overall.succeeded_starts,
            both->policy.overall.succeeded_starts);
  EXPECT_EQ(alone->overall.means.e_g_mpjpe_mm,
            both->policy.overall.means.e_g_mpjpe_mm);
  EXPECT_EQ(alone->clips.size(), 3u);
}

TEST(Evaluation, WritesTheDocumentedFields) {
  const Subject subject = RandomSubject();

  const Json file =
      Json::parse(JsonWith(subject, {.starts = 3, .seconds = 1, .threads = 2}));

  for (const char* set : {"overall", "successful", "zero_action"}) {
    for (const char* field :
         {"clips", "success_rate", "starts", "succeeded_starts", "e_g_mpjpe_mm",
          "e_mpjpe_mm", "e_acc", "e_vel", "body_mm"}) {
      EXPECT_TRUE(file.at(set).contains(field)) << set << " " << field;
    }
  }
  ASSERT_EQ(file["clips"].size(), 3u);
  const Json& turn = file["clips"][0];
  EXPECT_EQ(turn["name"], "turn");
  EXPECT_EQ(turn["starts"], 3);
  EXPECT_EQ(turn["success"], turn["succeeded_starts"] == 3);
  EXPECT_GT(turn["frames"], 0);
  EXPECT_TRUE(turn["failed_at_frame"].is_number_integer());
  EXPECT_EQ(file["overall"]["starts"], 9);
  EXPECT_EQ(file["bodies"].size(), file["overall"]["body_mm"].size());
  EXPECT_EQ(file["bundle"]["manifest_sha256"], "m");
}

// One frame has an error, but no change of it.
TEST(Evaluation, HasNoErrorThatWasNotMeasured) {
  const Json file = Json::parse(
      JsonWith(RandomSubject(), {.starts = 2, .seconds = 1.0 / 30}));

  const Json& turn = file["clips"][0];  // the others run to their ends
  EXPECT_EQ(turn["frames"], 2);
  EXPECT_TRUE(turn["e_g_mpjpe_mm"].is_number());
  EXPECT_TRUE(turn["e_vel"].is_null());
  EXPECT_TRUE(turn["e_acc"].is_null());
  EXPECT_TRUE(file["overall"]["e_acc"].is_number());
}

TEST(Evaluation, SaysWhereItIsRandomised) {
  v1::Recipe recipe = world::testing::ToyRecipe();
  recipe.mutable_task()->mutable_randomisation()->set_mass(0.1);
  const EvaluationOptions options = {.starts = 1, .seconds = 0.5};
  for (const bool randomised : {false, true}) {
    recipe.mutable_task()->mutable_randomisation()->set_in_evaluation(
        randomised);
    auto toy = world::testing::MakeToyWorld(recipe);
    const auto subject = MakeZeroActionSubject(
        toy.recipe, std::move(toy.character), std::move(toy.library));
    ASSERT_THAT(subject, IsOk());

    const Json file = Json::parse(JsonWith(*subject, options));

    ASSERT_EQ(file.contains("randomised"), randomised);
    if (!randomised) continue;
    EXPECT_EQ(file["randomised"]["seed"], 0);
  }
}

TEST(Evaluation, WritesLeftOutClipsApartWhereThereAreAny) {
  const Subject subject = RandomSubject();
  const EvaluationOptions options = {.starts = 1, .seconds = 0.5};
  auto evaluation = Evaluate(subject, options, StopToken());
  ASSERT_THAT(evaluation, IsOk());
  const auto write = [&] {
    return Json::parse(EvaluationJson(subject, options, {}, *evaluation));
  };
  EXPECT_FALSE(write().contains("training"));
  EXPECT_FALSE(write().contains("left_out"));

  evaluation->policy.left_out = evaluation->policy.overall;

  const Json split = write();
  EXPECT_EQ(split["training"]["clips"], 3);
  EXPECT_EQ(split["training"]["successful"]["clips"],
            split["successful"]["clips"]);
  EXPECT_EQ(split["training"]["zero_action"]["clips"], 3);
  EXPECT_EQ(split["left_out"]["starts"], 3);
}

TEST(Evaluation, TellsWhatSurvivesFromItsFirstFrame) {
  const Json one =
      Json::parse(JsonWith(RandomSubject(), {.starts = 1, .seconds = 0.5}));
  EXPECT_EQ(one["overall"]["first_start_successes"],
            one["overall"]["succeeded_clips"]);

  const Json two =
      Json::parse(JsonWith(RandomSubject(), {.starts = 2, .seconds = 0.5}));
  int survive = 0;
  for (size_t i = 0; i < two["clips"].size(); ++i) {
    const Json& clip = two["clips"][i];
    survive += clip["first_start_success"] ? 1 : 0;
    // The other start is another; the first is the same.
    EXPECT_EQ(clip["first_start_success"],
              one["clips"][i]["first_start_success"]);
  }
  EXPECT_EQ(two["overall"]["first_start_successes"], survive);
}

TEST(Evaluation, CountsWhatTheImportTurnedAwayAsFailed) {
  const Subject subject = RandomSubject();
  const EvaluationOptions options = {.starts = 1, .seconds = 0.5};
  const auto evaluation = Evaluate(subject, options, StopToken());
  ASSERT_THAT(evaluation, IsOk());
  EXPECT_FALSE(Json::parse(EvaluationJson(subject, options, {}, *evaluation))
                   .contains("imported"));

  const Json imported = Json::parse(EvaluationJson(subject, options,
                                                   {.bundle = "b",
                                                    .manifest_sha256 = "m",
                                                    .motions = "l",
                                                    .rejected_clips = 2},
                                                   *evaluation))["imported"];

  const int succeeded = evaluation->policy.overall.succeeded_clips;
  EXPECT_EQ(imported["clips"], 5);
  EXPECT_EQ(imported["rejected_clips"], 2);
  EXPECT_EQ(imported["succeeded_clips"], succeeded);
  EXPECT_DOUBLE_EQ(imported["success_rate"], succeeded / 5.0);
}

TEST(Evaluation, TellsWhichClipsAreLeftOut) {
  world::testing::ToyWorld toy = world::testing::MakeToyWorld();
  LeaveOut({1}, toy);
  const auto subject = MakeZeroActionSubject(
      toy.recipe, std::move(toy.character), std::move(toy.library));
  ASSERT_THAT(subject, IsOk());

  const Json file =
      Json::parse(JsonWith(*subject, {.starts = 1, .seconds = 0.5}));

  ASSERT_TRUE(file.contains("training"));
  EXPECT_EQ(file["training"]["clips"], 2);
  EXPECT_EQ(file["left_out"]["clips"], 1);
  EXPECT_FALSE(file["clips"][0].contains("left_out"));
  EXPECT_EQ(file["clips"][1]["left_out"], true);
}

TEST(Evaluation, SaysWhatClipsWereToABundleThatSaysSo) {
  const Subject subject = RandomSubject();
  const EvaluationOptions options = {.starts = 1, .seconds = 0.5};
  const auto evaluation = Evaluate(subject, options, StopToken());
  ASSERT_THAT(evaluation, IsOk());
  const auto clips = [&](const EvaluationSource& source) {
    return Json::parse(
        EvaluationJson(subject, options, source, *evaluation))["clips"];
  };
  EXPECT_FALSE(clips({})[0].contains("use"));

  EvaluationSource source;
  source.clip_uses = {{"turn", v1::CLIP_USE_TRAINED_ON},
                      {"sway", v1::CLIP_USE_LEFT_OUT}};
  const Json said = clips(source);

  EXPECT_EQ(said[0]["use"], "trained on");
  EXPECT_EQ(said[1]["use"], "left out");
  EXPECT_EQ(said[2]["use"], "not in training");
}

TEST(Evaluation, AClipSucceedsOnlyIfAllItsStartsDo) {
  const Json file = Json::parse(
      JsonWith(RandomSubject(), {.starts = 5, .seconds = 1, .threads = 2}));

  // No physics follows "tumble"; "sway" just stands.
  EXPECT_TRUE(file["clips"][1]["success"]);
  EXPECT_EQ(file["clips"][1]["failed_at_frame"], -1);
  EXPECT_FALSE(file["clips"][2]["success"]);
  EXPECT_LT(file["clips"][2]["succeeded_starts"], 5);
  EXPECT_GE(file["clips"][2]["failed_at_frame"], 1);
  int succeeded = 0;
  for (const Json& clip : file["clips"]) succeeded += clip["success"] ? 1 : 0;
  EXPECT_EQ(file["successful"]["clips"], succeeded);
  EXPECT_DOUBLE_EQ(file["overall"]["success_rate"], succeeded / 3.0);
}

TEST(Evaluation, ProfilesAddUpToTheErrorsOfTheRollouts) {
  const Subject subject = RandomSubject();
  const EvaluationOptions options = {
      .starts = 9, .seconds = 2, .threads = 2, .profiles = 2};

  const auto evaluation = Evaluate(subject, options, StopToken());

  ASSERT_THAT(evaluation, IsOk());
  ASSERT_EQ(evaluation->profiles.size(), 2u);  // of three clips
  for (int clip = 0; clip < 2; ++clip) {
    const ClipSummary& summary = evaluation->policy.clips[clip];
    const ErrorProfile& profile = evaluation->profiles[clip];
    std::vector<double> means;
    for (size_t body = 0; body < summary.body_mm.size(); ++body) {
      means.push_back(profile.sum_mm(static_cast<int>(body)) /
                      static_cast<double>(summary.frames));
    }
    // Equal but for the order of summation.
    EXPECT_THAT(means, Pointwise(DoubleNear(1e-6), summary.body_mm));
  }
}

TEST(Evaluation, OfTheZeroActionAsPolicyEqualsItsBaseline) {
  world::testing::ToyWorld toy = world::testing::MakeToyWorld();
  const auto subject = MakeZeroActionSubject(
      toy.recipe, std::move(toy.character), std::move(toy.library));
  ASSERT_THAT(subject, IsOk());

  Json file = Json::parse(
      JsonWith(*subject, {.starts = 2, .seconds = 1, .threads = 1}));

  EXPECT_EQ(file["overall"], file["zero_action"]);
}

TEST(Evaluation, ErrorsOfNoFramesAreNullNotZero) {
  const Subject subject = RandomSubject();
  Evaluation nothing;

  const Json file = Json::parse(EvaluationJson(subject, {}, {}, nothing));

  EXPECT_TRUE(file["successful"]["e_g_mpjpe_mm"].is_null());
  EXPECT_EQ(file["successful"]["clips"], 0);
}

TEST(Evaluation, RefusesOptionsOutOfRange) {
  const Subject subject = RandomSubject();

  EXPECT_THAT(Evaluate(subject, {.starts = 0}, StopToken()),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("starts: expected >= 1, found 0")));
  EXPECT_THAT(Evaluate(subject, {.threads = 0}, StopToken()),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("threads: expected >= 1, found 0")));
}

TEST(Evaluation, StopsWhenAsked) {
  StopSource source;
  source.request_stop();

  EXPECT_THAT(Evaluate(RandomSubject(), {}, source.get_token()),
              StatusIs(absl::StatusCode::kCancelled, HasSubstr("stopped")));
}

TEST(Subjects, RefuseALibraryOfAnotherRate) {
  v1::Recipe recipe = world::testing::ToyRecipe();
  world::testing::ToyWorld toy = world::testing::MakeToyWorld(recipe);
  recipe.mutable_physics()->set_control_hz(60);

  EXPECT_THAT(MakeZeroActionSubject(recipe, std::move(toy.character),
                                    std::move(toy.library)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("frames_per_second: expected 60")));
}

TEST(Subjects, NameTheClipsThereAre) {
  const Subject subject = RandomSubject();

  EXPECT_THAT(FindClip(subject.library(), "walk"),
              StatusIs(absl::StatusCode::kNotFound,
                       HasSubstr("clip \"walk\": expected one of 3 clips "
                                 "(turn, sway, tumble)")));
  EXPECT_EQ(*FindClip(subject.library(), "sway"), 1);
  EXPECT_EQ(*FindClip(subject.library(), ""), 0);
}

TEST(Groups, HoldNeighboursOfOneClip) {
  std::vector<v1::EvaluationStart> starts(13);
  for (size_t i = 10; i < starts.size(); ++i) starts[i].set_clip(1);

  std::vector<size_t> sizes;
  for (const StartGroup& group : GroupStarts(starts)) {
    sizes.push_back(group.size);
  }

  EXPECT_THAT(sizes, ElementsAre(8, 2, 3));
}

TEST(Recordings, BeginAtTheReferenceAndFollowIt) {
  const Subject subject = RandomSubject(/*gain=*/0.01);

  const auto recording = RecordClip(subject, /*clip=*/1, 0.5, StopToken());

  ASSERT_THAT(recording, IsOk());
  EXPECT_TRUE(recording->survived);
  EXPECT_EQ(recording->frames(), 16);  // 0.5 s at 30 Hz, and the start
  EXPECT_EQ(recording->reference.size(), recording->simulated.size());
  std::vector<double> difference;
  for (int i = 0; i < recording->nq; ++i) {
    difference.push_back(recording->simulated[i] - recording->reference[i]);
  }
  EXPECT_THAT(difference, Each(DoubleNear(0, 1e-12)));
}

TEST(Recordings, OfAClipThatDoesNotLoopEndWithIt) {
  const Subject subject = RandomSubject();

  EXPECT_EQ(FramesToShow(subject.library(), /*clip=*/1, 100), 20);
  EXPECT_EQ(FramesToShow(subject.library(), /*clip=*/0, 100), 3001);
}

}  // namespace
}  // namespace sinew::evaluation
