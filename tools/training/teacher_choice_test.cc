#include "tools/training/teacher_choice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/files.h"
#include "common/testing/matchers.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "sim/motion/library.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::IsOkAndHolds;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

using Json = nlohmann::json;

// The toy's library, and bundles that could teach its clips turn, sway, tumble.
struct Fixture {
  static TeacherCandidate Candidate(const std::string& name,
                                    std::set<std::string> clips) {
    return {.name = name,
            .manifest_sha256 = name + "'s digest",
            .clips = std::move(clips)};
  }
  // What `sinew eval` says of a bundle: by clip, of 10 starts how many succeed
  // and how many frames survive.
  Json Evaluation(const std::string& bundle,
                  const std::vector<std::pair<int, int>>& scores) const {
    Json clips = Json::array();
    for (size_t c = 0; c < scores.size(); ++c) {
      clips.push_back({{"name", toy.library->clip(static_cast<int>(c)).name()},
                       {"succeeded_starts", scores[c].first},
                       {"frames", scores[c].second},
                       {"e_g_mpjpe_mm", 50.0}});
    }
    return {{"bundle", {{"manifest_sha256", bundle + "'s digest"}}},
            {"library", {{"sha256", toy.library->digest()}}},
            {"starts_per_clip", 10},
            {"seconds", 10.0},
            {"definitions", {{"fall_distance_m", 0.5}}},
            {"clips", clips}};
  }
  std::string Write(const std::string& name, const std::string& text) const {
    const std::string file = JoinPath(toy.folder, name);
    EXPECT_THAT(WriteFileAtomically(file, text), IsOk());
    return file;
  }
  std::string Write(const std::string& name, const Json& evaluation) const {
    return Write(name, evaluation.dump());
  }

  const world::testing::ToyWorld toy = world::testing::MakeToyWorld();
  const std::vector<TeacherCandidate> two = {
      Candidate("walker", {"turn", "sway", "tumble"}),
      Candidate("tumbler", {"turn", "sway", "tumble"})};
  const std::vector<std::pair<int, int>> walks = {{10, 240}, {7, 150}, {0, 30}};
  const std::vector<std::pair<int, int>> tumbles = {
      {10, 240}, {2, 190}, {0, 31}};
  // Files of what evaluations say of the two.
  const std::string walker = Write("walker.json", Evaluation("walker", walks));
  const std::string tumbler =
      Write("tumbler.json", Evaluation("tumbler", tumbles));
};

TEST(TeacherChoice, ByTrainingIsTheNarrowestOfAClip) {
  const Fixture f;
  const std::vector<TeacherCandidate> candidates = {
      Fixture::Candidate("all", {"turn", "sway", "tumble"}),
      Fixture::Candidate("one", {"sway"}),
      Fixture::Candidate("pair", {"sway", "tumble"})};

  EXPECT_THAT(
      ChooseByTraining(candidates, f.toy.recipe.task().start(), *f.toy.library),
      IsOkAndHolds(ElementsAre(0, 1, 2)));
}

TEST(TeacherChoice, ByTrainingRefusesBundlesThatKnowAClipEquallyWell) {
  const Fixture f;
  std::vector<TeacherCandidate> candidates = {
      Fixture::Candidate("all", {"turn", "sway", "tumble"}),
      Fixture::Candidate("front", {"turn", "sway"}),
      Fixture::Candidate("back", {"sway", "tumble"})};
  v1::Start start = f.toy.recipe.task().start();

  EXPECT_THAT(ChooseByTraining(candidates, start, *f.toy.library),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("clip sway"),
                             HasSubstr("front and back of 2 clips each"),
                             HasSubstr("--teacher-eval"))));
  // Of what no start is drawn from, either may know more.
  start.add_only_clips("turn");
  start.add_only_clips("tumble");
  EXPECT_THAT(ChooseByTraining(candidates, start, *f.toy.library), IsOk());
  // A bundle of that clip alone settles it.
  start.clear_only_clips();
  candidates.push_back(Fixture::Candidate("middle", {"sway"}));
  EXPECT_THAT(ChooseByTraining(candidates, start, *f.toy.library),
              IsOkAndHolds(ElementsAre(1, 3, 2)));
}

// A start that is won counts for more than any frames; of none won, they
// decide.
TEST(TeacherChoice, ByEvaluationIsTheOneThatWinsMostThenSurvivesLongest) {
  const Fixture f;

  const auto choice =
      ChooseByEvaluation(f.two, {f.walker, f.tumbler}, *f.toy.library);

  ASSERT_THAT(choice, IsOk());
  EXPECT_EQ((*choice)[1], 0);
  EXPECT_EQ((*choice)[2], 1);
}

// Both survive all of the first clip.
TEST(TeacherChoice, ByEvaluationOfEqualsIsTheNearestWhateverTheOrder) {
  const Fixture f;
  Json near = f.Evaluation("walker", f.walks);
  near["clips"][0]["e_g_mpjpe_mm"] = 20.0;
  f.Write("walker.json", near);
  const std::vector<TeacherCandidate> turned = {f.two[1], f.two[0]};

  for (const auto& files :
       {std::vector{f.walker, f.tumbler}, std::vector{f.tumbler, f.walker}}) {
    EXPECT_THAT(ChooseByEvaluation(f.two, files, *f.toy.library),
                IsOkAndHolds(ElementsAre(0, 0, 1)));
    EXPECT_THAT(ChooseByEvaluation(turned, files, *f.toy.library),
                IsOkAndHolds(ElementsAre(1, 1, 0)));
  }
  // Equal in all, by digest; one that compared no frame has no error.
  near["clips"][0]["e_g_mpjpe_mm"] = 50.0;
  f.Write("walker.json", near);
  EXPECT_THAT(ChooseByEvaluation(f.two, {f.walker, f.tumbler}, *f.toy.library),
              IsOkAndHolds(ElementsAre(1, 0, 1)));
  EXPECT_THAT(ChooseByEvaluation(turned, {f.walker, f.tumbler}, *f.toy.library),
              IsOkAndHolds(ElementsAre(0, 1, 0)));
  Json nothing = f.Evaluation("tumbler", f.tumbles);
  nothing["clips"][0]["e_g_mpjpe_mm"] = nullptr;
  f.Write("tumbler.json", nothing);
  EXPECT_THAT(ChooseByEvaluation(f.two, {f.walker, f.tumbler}, *f.toy.library),
              IsOkAndHolds(ElementsAre(0, 0, 1)));
}

TEST(TeacherChoice, ByEvaluationWantsOneOfEachBundle) {
  const Fixture f;
  const std::string again =
      f.Write("again.json", f.Evaluation("walker", f.tumbles));
  const std::string stranger =
      f.Write("stranger.json", f.Evaluation("stranger", f.walks));
  const auto choose = [&](const std::vector<std::string>& files) {
    return ChooseByEvaluation(f.two, files, *f.toy.library);
  };

  EXPECT_THAT(choose({f.walker}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("--teacher-eval"),
                             HasSubstr("none of tumbler"))));
  EXPECT_THAT(choose({f.walker, again}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr(again), HasSubstr(f.walker),
                             HasSubstr("found walker's digest"))));
  EXPECT_THAT(choose({f.walker, stranger}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr(stranger), HasSubstr("walker, tumbler"),
                             HasSubstr("found stranger's digest"))));
}

TEST(TeacherChoice, ByEvaluationComparesEqualStartsOfTheSameLibrary) {
  const Fixture f;
  Json other_starts = f.Evaluation("tumbler", f.tumbles);
  other_starts["starts_per_clip"] = 4;
  Json other_seconds = f.Evaluation("tumbler", f.tumbles);
  other_seconds["seconds"] = 5.0;
  Json strict = f.Evaluation("tumbler", f.tumbles);
  strict["definitions"]["fall_distance_m"] = 0.25;
  Json randomised = f.Evaluation("tumbler", f.tumbles);
  randomised["randomised"] = {{"seed", 1}};
  Json other_library = f.Evaluation("tumbler", f.tumbles);
  other_library["library"]["sha256"] = "another";
  Json lacks_a_clip = f.Evaluation("tumbler", {{1, 1}, {1, 1}});
  const std::pair<Json, std::string> cases[] = {
      {other_starts, "starts_per_clip: expected 10, found 4"},
      {other_seconds, "seconds: expected 10.0, found 5.0"},
      {strict, "definitions.fall_distance_m: expected 0.5, found 0.25"},
      {randomised, "randomised: expected null, found {"},
      {other_library, "library.sha256: expected " + f.toy.library->digest()},
      {lacks_a_clip, "clips: expected one named tumble, found none"}};
  for (const auto& [evaluation, message] : cases) {
    const std::string file = f.Write("tumbler.json", evaluation);

    EXPECT_THAT(ChooseByEvaluation(f.two, {f.walker, file}, *f.toy.library),
                StatusIs(absl::StatusCode::kInvalidArgument,
                         AllOf(HasSubstr(file), HasSubstr(message))));
  }
  const std::string file = f.Write("tumbler.json", other_starts);
  EXPECT_THAT(ChooseByEvaluation(f.two, {f.walker, file}, *f.toy.library),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("what " + f.walker + " has")));
}

TEST(TeacherChoice, ByEvaluationNamesAFileThatIsNone) {
  const Fixture f;
  Json lacks_starts = f.Evaluation("tumbler", f.tumbles);
  lacks_starts.erase("starts_per_clip");
  Json has_words = f.Evaluation("tumbler", f.tumbles);
  has_words["clips"][1]["succeeded_starts"] = "all";
  for (const std::string& text :
       {std::string("not JSON"), std::string("[]"), std::string("{}"),
        lacks_starts.dump(), has_words.dump()}) {
    const std::string file = f.Write("tumbler.json", text);

    EXPECT_THAT(ChooseByEvaluation(f.two, {file}, *f.toy.library),
                StatusIs(absl::StatusCode::kInvalidArgument,
                         AllOf(HasSubstr(file), HasSubstr("sinew eval"))));
  }
  const std::string missing = JoinPath(f.toy.folder, "missing.json");
  EXPECT_THAT(ChooseByEvaluation(f.two, {missing}, *f.toy.library),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr(missing)));
}

}  // namespace
}  // namespace sinew::tools
