// The figures of a model card: evaluations and samples.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "sim/motion/library.h"
#include "sim/world/testing/toy_world.h"
#include "tools/zoo/testing/model_card_rig.h"

namespace sinew::zoo {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;

class ModelCardFigures : public ModelCardRig {};

TEST_F(ModelCardFigures, TellStartsOfClipsThatAreLeftOutApart) {
  world::testing::LeaveOutOnDisk(2, options_.motions);
  Evaluate();

  const auto card = Card();

  // No physics follows the third clip.
  ASSERT_THAT(card, IsOk());
  EXPECT_THAT(*card, HasSubstr("It wins 2 of 2 starts, 2 of 2 clips from their "
                               "first frame; of those left out 0 of 1 starts, "
                               "0 of 1 clips from their first frame."));
}

TEST_F(ModelCardFigures, DoWithoutFirstFramesThatWereNotKept) {
  Evaluate();
  std::string text = *ReadFile(options_.eval);
  text = absl::StrReplaceAll(text, {{"first_start_successes", "unknown"}});
  ASSERT_THAT(WriteFileAtomically(options_.eval, text), IsOk());

  const auto card = Card();

  ASSERT_THAT(card, IsOk());
  EXPECT_THAT(*card, HasSubstr("- of 3 clips from their first frame"));
}

TEST_F(ModelCardFigures, SaysWhatThePriorDoes) {
  const auto bundle = bundle::ReadBundle(options_.bundle);
  ASSERT_THAT(bundle, IsOk());
  const auto library = motion::Library::Load(options_.motions);
  ASSERT_THAT(library, IsOk());
  options_.samples = Path("samples.json");
  const auto write = [&](const std::string& digest, const std::string& of) {
    EXPECT_THAT(
        WriteFileAtomically(
            options_.samples,
            absl::StrCat(
                R"({"manifest_sha256": ")", digest,
                R"(", "start": "standing", "seconds": 10, "library": {"sha256":
                ")",
                of, R"(", "transitions": 120, "threshold": 0.5}, "ways": [
                {"name": "noise 0.5", "samples": 256, "upright_share": 0.75,
                 "got_up_share": null,
                 "transitions": {"coverage": 0.5, "distance": 0.4687},
                 "diversity": {"over_time_m": 0.116},
                 "foot_skate_m_per_s": 0.06, "joint_speed_rad_per_s": 0.683,
                 "latent": {"ratio": 0.27}, "student_coverage": 0.8125},
                {"name": "zero action", "samples": 64, "diversity": null}]})")),
        IsOk());
  };
  write(bundle->manifest.manifest_sha256(), (*library)->digest());

  const auto card = Card();

  ASSERT_THAT(card, IsOk());
  EXPECT_THAT(*card,
              AllOf(HasSubstr("10 s from starts `standing`, of 120 "
                              "transitions of the library (threshold 0.5)"),
                    HasSubstr("| noise 0.5 | 256 | 75.0 % | - | 50.0 % | "
                              "81.2 % | 0.469 | 0.116 | 0.060 | 0.68 | 0.27 |"),
                    HasSubstr("| zero action | 64 | - | - | - | - | - | - | - "
                              "| - | - |")));

  const std::string good = *ReadFile(options_.samples);
  for (const auto& [from, to] :
       {std::pair("\"standing\"", "3"), std::pair("\"noise 0.5\"", "null"),
        std::pair("{\"coverage\": 0.5, \"distance\": 0.4687}", "[]"),
        std::pair("\"ways\"", "\"others\"")}) {
    EXPECT_THAT(WriteFileAtomically(options_.samples,
                                    absl::StrReplaceAll(good, {{from, to}})),
                IsOk());
    EXPECT_THAT(Card(), StatusIs(absl::StatusCode::kInvalidArgument,
                                 HasSubstr("samples.json")))
        << to;
  }
  write("ab", (*library)->digest());
  EXPECT_THAT(Card(), StatusIs(absl::StatusCode::kInvalidArgument,
                               AllOf(HasSubstr("samples.json"),
                                     HasSubstr("manifest_sha256"))));
  write(bundle->manifest.manifest_sha256(), "cd");
  EXPECT_THAT(Card(), StatusIs(absl::StatusCode::kInvalidArgument,
                               HasSubstr("library.sha256")));
}

TEST_F(ModelCardFigures, SaysThatNothingWasEvaluated) {
  const auto card = Card();

  ASSERT_THAT(card, IsOk());
  EXPECT_THAT(*card, AllOf(HasSubstr("Not evaluated."),
                           HasSubstr("nothing is known of its limits"),
                           HasSubstr("| machine | unknown |")));
}

TEST_F(ModelCardFigures, RefusesAnEvaluationOfAnotherBundleOrLibrary) {
  Evaluate();
  const std::string good = *ReadFile(options_.eval);
  ASSERT_THAT(WriteFileAtomically(options_.eval, "{}"), IsOk());
  EXPECT_THAT(Card(), StatusIs(absl::StatusCode::kInvalidArgument,
                               AllOf(HasSubstr("eval.json"),
                                     HasSubstr("bundle.manifest_sha256"))));

  ASSERT_THAT(WriteFileAtomically(options_.eval, good), IsOk());
  const std::string manifest = JoinPath(options_.motions, "manifest.json");
  ASSERT_THAT(WriteFileAtomically(manifest, *ReadFile(manifest) + "\n"),
              IsOk());
  EXPECT_THAT(Card(), StatusIs(absl::StatusCode::kInvalidArgument,
                               HasSubstr("library.sha256")));
}

TEST_F(ModelCardFigures, ShowsFallenFiguresWithoutThoseOfTheZeroAction) {
  Evaluate();
  options_.fallen = options_.eval;
  AddToEvaluation(
      "\"fallen\": {\"starts\": 8, \"recovered_3_s\": 0.25, "
      "\"recovered_5_s\": 0.75, \"zero_action\": {}},");

  const auto card = Card();

  ASSERT_THAT(card, IsOk());
  EXPECT_THAT(*card, AllOf(HasSubstr("(zero action: 0.0 %, 0.0 %)"),
                           HasSubstr("--fallen 8 --out eval.json")));
}

TEST_F(ModelCardFigures, ShowsFiguresOfGetUpsWhereThereAreAny) {
  Evaluate();
  options_.fallen = options_.eval;
  AddToEvaluation(
      "\"fallen\": {\"starts\": 8, \"recovered_3_s\": 0, "
      "\"recovered_5_s\": 0, \"zero_action\": {}, \"get_up\": "
      "{\"recovered_3_s\": 0.25, \"recovered_5_s\": 0.75, "
      "\"zero_action\": {\"recovered_5_s\": 0.125}}},");

  const auto card = Card();

  ASSERT_THAT(card, IsOk());
  EXPECT_THAT(*card, HasSubstr("With the library's nearest get-up for a "
                               "reference and, once that is over, its nearest "
                               "frame that stays up: 25.0 %, 75.0 % (zero "
                               "action: 0.0 %, 12.5 %)."));
}

TEST_F(ModelCardFigures, WantsFallenFiguresWhereTheyAreNamed) {
  Evaluate();
  options_.fallen = options_.eval;

  EXPECT_THAT(Card(), StatusIs(absl::StatusCode::kInvalidArgument,
                               HasSubstr("fallen: expected an object")));

  AddToEvaluation(
      "\"fallen\": {\"starts\": 8, \"recovered_3_s\": 0.25, "
      "\"recovered_5_s\": 0.75, \"zero_action\": {\"recovered_3_s\": 0.125, "
      "\"recovered_5_s\": 0.5}},");
  const auto card = Card();
  ASSERT_THAT(card, IsOk());
  EXPECT_THAT(*card, HasSubstr("Of 8 fallen starts, 25.0 % stand and track "
                               "again within 3 s, 75.0 % within 5 s "
                               "(zero action: 12.5 %, 50.0 %)"));
}

}  // namespace
}  // namespace sinew::zoo
