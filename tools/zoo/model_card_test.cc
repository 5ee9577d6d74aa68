#include "tools/zoo/model_card.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "common/clock.h"
#include "common/config/recipe.h"
#include "common/files.h"
#include "common/stop.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "deploy/bundle/testing/toy_latent.h"
#include "learner/procedure/procedure.h"
#include "proto/sinew/v1/bundle.pb.h"
#include "sim/motion/library.h"
#include "sim/world/testing/toy_world.h"
#include "tools/evaluation/evaluate_bundle.h"
#include "tools/training/procedure_record.h"
#include "tools/zoo/card_facts.h"
#include "tools/zoo/zoo_entry.h"

namespace sinew::zoo {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

// A bundle of the toy world in a folder as zoo/ has them.
class ModelCardTest : public ::testing::Test {
 protected:
  ModelCardTest() : toy_(world::testing::MakeToyWorld()) {
    EXPECT_THAT(MakeDirectories(Path("entry")), IsOk());
    options_.bundle = Path("entry/bundle");
    options_.motions = toy_.library_folder;
    EXPECT_THAT(
        bundle::WriteBundle(bundle::testing::ToyContent(toy_), options_.bundle),
        IsOk());
  }

  std::string Path(const std::string& name) const {
    return JoinPath(toy_.folder, name);
  }
  void Evaluate() {
    options_.eval = Path("eval.json");
    EXPECT_THAT(evaluation::EvaluateBundle(
                    options_.bundle, options_.motions, options_.eval,
                    {.starts = 1, .seconds = 0.5}, StopToken())
                    .status(),
                IsOk());
  }
  // Puts a field, with the comma after it, before those that are there.
  void AddToEvaluation(const std::string& field) {
    std::string text = *ReadFile(options_.eval);
    text.insert(text.find('{') + 1, field);
    EXPECT_THAT(WriteFileAtomically(options_.eval, text), IsOk());
  }
  absl::StatusOr<std::string> Card() const {
    const auto facts = ReadCardFacts(options_, clock_);
    if (!facts.ok()) return facts.status();
    return ModelCard(*facts);
  }

  const SystemClock clock_;
  const world::testing::ToyWorld toy_;
  CardOptions options_;
};

TEST_F(ModelCardTest, SaysWhatTheBundleIsAndWhichClipsFail) {
  Evaluate();

  const auto card = Card();

  ASSERT_THAT(card, IsOk());
  const auto bundle = bundle::ReadBundle(options_.bundle);
  ASSERT_THAT(bundle, IsOk());
  EXPECT_THAT(*card, AllOf(HasSubstr("character toy"), HasSubstr("4 joints"),
                           HasSubstr(bundle->manifest.manifest_sha256()),
                           HasSubstr("| samples | 6144 |"),
                           HasSubstr("Trained on: turn, sway, tumble."),
                           HasSubstr("\n- Apache-2.0\n")));
  // No physics follows "tumble", "sway" just stands.
  EXPECT_THAT(*card, AllOf(HasSubstr("| tumble | trained on | 0."),
                           Not(HasSubstr("| sway | trained on |")),
                           HasSubstr("| zero action, errors until it fails |"),
                           HasSubstr("--starts 1 --seconds 0.5")));
  EXPECT_THAT(*card, AllOf(HasSubstr("sinew_open(\"bundle\""),
                           HasSubstr("bundle/policy.onnx")));
  // With its figures and its recipe it is an entry of zoo/.
  ASSERT_THAT(WriteFileAtomically(Path("entry/CARD.md"), *card), IsOk());
  ASSERT_THAT(WriteFileAtomically(Path("entry/eval.json"),
                                  absl::StrReplaceAll(*ReadFile(options_.eval),
                                                      {{toy_.folder, "lib"}})),
              IsOk());
  ASSERT_THAT(WriteFileAtomically(Path("entry/recipe.textproto"),
                                  PrintRecipe(toy_.recipe)),
              IsOk());
  EXPECT_THAT(CheckZooEntry(Path("entry")), IsOk());
}

TEST_F(ModelCardTest, SaysWhatThePriorDoes) {
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
                 "got_up_share": null, "transitions": {"coverage": 0.5},
                 "student_coverage": 0.8125}]})")),
        IsOk());
  };
  write(bundle->manifest.manifest_sha256(), (*library)->digest());

  const auto card = Card();

  ASSERT_THAT(card, IsOk());
  EXPECT_THAT(*card,
              AllOf(HasSubstr("10 s from starts `standing`, of 120 "
                              "transitions of the library (threshold 0.5)"),
                    HasSubstr("| noise 0.5 | 256 | 75.0 % | - | 50.0 % | "
                              "81.2 % |")));

  const std::string good = *ReadFile(options_.samples);
  for (const auto& [from, to] :
       {std::pair("\"standing\"", "3"), std::pair("\"noise 0.5\"", "null"),
        std::pair("{\"coverage\": 0.5}", "[]"),
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

TEST_F(ModelCardTest, SaysThatNothingWasEvaluated) {
  const auto card = Card();

  ASSERT_THAT(card, IsOk());
  EXPECT_THAT(*card, AllOf(HasSubstr("Not evaluated."),
                           HasSubstr("nothing is known of its limits"),
                           HasSubstr("| machine | unknown |")));
}

TEST_F(ModelCardTest, SaysHowAStudentOfATeacherIsMadeAgainAndSteered) {
  const world::testing::ToyWorld toy =
      world::testing::MakeToyWorld(bundle::testing::ToyLatentRecipe());
  bundle::BundleContent content = bundle::testing::ToyLatentContent(toy);
  v1::BundleSource* teacher =
      content.manifest.mutable_provenance()->add_sources();
  teacher->set_role("teacher");
  teacher->set_recipe("phc_plus");
  teacher->set_manifest_sha256("abc");
  // As a bundle of an old version.
  content.manifest.mutable_provenance()->clear_clip_uses();
  ASSERT_THAT(bundle::WriteBundle(content, options_.bundle), IsOk());

  const auto card = Card();

  ASSERT_THAT(card, IsOk());
  EXPECT_THAT(*card, AllOf(HasSubstr(" --teacher phc_plus\n"),
                           HasSubstr("they may have seen clips that are left "
                                     "out above"),
                           HasSubstr("double mean[6], std[6];"),
                           HasSubstr("sinew_decode(policy, &state, mean, 6, "
                                     "target);")));
}

TEST_F(ModelCardTest, SaysWhichOfSeveralTeachersLabelledWhat) {
  bundle::BundleContent content = bundle::testing::ToyContent(toy_);
  v1::BundleProvenance& provenance = *content.manifest.mutable_provenance();
  using Clips = std::vector<const char*>;
  for (const Clips& labelled : {Clips{"turn"}, Clips{"sway", "tumble"}, {}}) {
    v1::BundleSource* teacher = provenance.add_sources();
    teacher->set_role("teacher");
    teacher->set_recipe("track_library");
    teacher->set_manifest_sha256(absl::StrCat("abc", labelled.size()));
    for (auto& clip : labelled) teacher->mutable_labelled()->add_clips(clip);
  }
  ASSERT_THAT(bundle::WriteBundle(content, options_.bundle), IsOk());

  const auto card = Card();

  ASSERT_THAT(card, IsOk());
  EXPECT_THAT(*card,
              AllOf(HasSubstr("| teacher of 1 clip | track_library, abc1 |\n"
                              "| teacher of 2 clips | track_library, abc2 |\n"
                              "| teacher | track_library, abc0 |\n"),
                    HasSubstr("\ntrack_library, abc1: turn.\n\ntrack_library, "
                              "abc2: sway, tumble.\n\n</details>\n")));
}

TEST_F(ModelCardTest, SaysWhatTheClipsWereToTraining) {
  bundle::BundleContent content = bundle::testing::ToyContent(toy_);
  v1::BundleProvenance& provenance = *content.manifest.mutable_provenance();
  provenance.set_clip_uses(1, v1::CLIP_USE_LEFT_OUT);
  provenance.set_clip_uses(2, v1::CLIP_USE_SOURCE_TRAINED_ON);
  provenance.add_sources()->set_role("init");
  const auto written = [&] {
    EXPECT_THAT(bundle::WriteBundle(content, options_.bundle), IsOk());
    Evaluate();
    return Card();
  };

  const auto card = written();

  ASSERT_THAT(card, IsOk());
  EXPECT_THAT(
      *card,
      AllOf(HasSubstr("Clips: 1, and 1 left out of training."),
            HasSubstr("| 1 | trained on | made for tests (Apache-2.0) |\n"
                      "| 1 | trained on by a source | made for tests "
                      "(Apache-2.0) |\n"
                      "| 1 | left out | made for tests (Apache-2.0) |\n"),
            HasSubstr("\nTrained on: turn.\n\nTrained on by a source: tumble."
                      "\n\nLeft out: sway.\n"),
            HasSubstr("| tumble | trained on by a source | 0."),
            Not(HasSubstr("may have seen"))));

  provenance.set_clip_uses(2, v1::CLIP_USE_UNKNOWN);
  const auto unsure = written();
  ASSERT_THAT(unsure, IsOk());
  EXPECT_THAT(*unsure, AllOf(HasSubstr("\nUnknown: tumble.\n"),
                             HasSubstr("may have seen these clips"),
                             HasSubstr("| tumble | unknown | 0.")));
}

TEST_F(ModelCardTest, SaysWhereALeftOutClipWasTrainedOn) {
  Evaluate();
  const auto before = Card();
  ASSERT_THAT(before, IsOk());
  EXPECT_THAT(*before, Not(HasSubstr("this library leaves out")));
  world::testing::LeaveOutOnDisk(2, options_.motions);
  Evaluate();

  const auto card = Card();

  ASSERT_THAT(card, IsOk());
  EXPECT_THAT(*card, AllOf(HasSubstr("Of the clips that this library leaves "
                                     "out, 1 were trained on."),
                           HasSubstr("| tumble | trained on | 0.")));
}

TEST_F(ModelCardTest, SaysOfOldBundlesWhatTheirLibraryLeavesOut) {
  world::testing::LeaveOutOnDisk(1, options_.motions);
  const auto library = motion::Library::Load(options_.motions);
  ASSERT_THAT(library, IsOk());
  bundle::BundleContent content = bundle::testing::ToyContent(toy_);
  v1::BundleProvenance& provenance = *content.manifest.mutable_provenance();
  provenance.clear_clip_uses();
  provenance.set_library_sha256((*library)->digest());
  ASSERT_THAT(bundle::WriteBundle(content, options_.bundle), IsOk());

  const auto card = Card();

  ASSERT_THAT(card, IsOk());
  EXPECT_THAT(*card, AllOf(HasSubstr("Clips: 2, and 1 left out of training."),
                           HasSubstr("\nTrained on: turn, tumble.\n\nLeft "
                                     "out: sway.\n")));
}

TEST_F(ModelCardTest, AddsUpWhatAProcedureTook) {
  options_.run = Path("run");
  v1::Recipe recipe = toy_.recipe;
  recipe.set_name("toy_plus");
  recipe.set_seed(77);
  tools::ProcedureRecord record;
  record.stages.resize(3);
  for (size_t i = 0; i < 3; ++i) {
    tools::ProcedureRecord::Entry& stage = record.stages[i];
    stage.directory = absl::StrCat("stages/0", i);
    stage.decision.next = learner::Stage();
    // The last is there for comparison and no part of what it took.
    if (i == 2) stage.decision.next->kind = learner::StageKind::kSingle;
    stage.decision.reason = absl::StrCat("for reason ", i);
    stage.finished = learner::FinishedStage();
    stage.finished->stage = *stage.decision.next;
    stage.finished->samples = 1000;
    stage.finished->train_seconds = 5400;
    EXPECT_THAT(MakeDirectories(JoinPath(options_.run, stage.directory)),
                IsOk());
  }
  ASSERT_THAT(
      WriteFileAtomically(Path("run/config.textproto"), PrintRecipe(recipe)),
      IsOk());
  ASSERT_THAT(WriteFileAtomically(Path("run/procedure.json"),
                                  tools::PrintProcedure(record)),
              IsOk());
  ASSERT_THAT(WriteFileAtomically(Path("run/stages/01/metrics.jsonl"),
                                  "{\"cores\": 2}\n{\"cores\""),
              IsOk());

  const auto card = Card();

  ASSERT_THAT(card, IsOk());
  EXPECT_THAT(*card,
              AllOf(HasSubstr("# toy_plus, toy"), HasSubstr("| seed | 77 |"),
                    HasSubstr("| samples | 2000 |"), HasSubstr("3.00 h"),
                    HasSubstr("| machine | 2 cores, unknown |"),
                    HasSubstr("1. for reason 0\n1. for reason 1\n"),
                    HasSubstr("--recipe toy_plus --character toy")));
}

TEST_F(ModelCardTest, RefusesAnEvaluationOfAnotherBundleOrLibrary) {
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

TEST_F(ModelCardTest, ShowsFallenFiguresWithoutThoseOfTheZeroAction) {
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

TEST_F(ModelCardTest, ShowsFiguresOfGetUpsWhereThereAreAny) {
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

TEST_F(ModelCardTest, WantsFallenFiguresWhereTheyAreNamed) {
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
