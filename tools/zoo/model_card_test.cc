#include "tools/zoo/model_card.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "common/config/recipe.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "deploy/bundle/testing/toy_latent.h"
#include "learner/procedure/procedure.h"
#include "proto/sinew/v1/bundle.pb.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "sim/motion/library.h"
#include "sim/world/testing/toy_world.h"
#include "tools/training/procedure_record.h"
#include "tools/zoo/testing/model_card_rig.h"
#include "tools/zoo/zoo_entry.h"

namespace sinew::zoo {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TEST_F(ModelCardRig, SaysWhatTheBundleIsAndWhichClipsFail) {
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
                           HasSubstr("--starts 1 --seconds 0.5"),
                           HasSubstr("It wins 2 of 3 starts, 2 of 3 clips from "
                                     "their first frame.")));
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

TEST_F(ModelCardRig, SaysHowAStudentOfATeacherIsMadeAgainAndSteered) {
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
                           HasSubstr("```c\ndouble mean[6], std[6];"),
                           HasSubstr("sinew_decode(policy, &state, mean, 6, "
                                     "target);")));
}

// Which is what the runtime asks for.
TEST_F(ModelCardRig, BeginsAnEpisodeWhereTheDecoderSeesThePreviousTarget) {
  v1::Recipe recipe = bundle::testing::ToyLatentRecipe();
  v1::Observation& observation = *recipe.mutable_task()->mutable_observation();
  observation.clear_blocks();
  observation.add_blocks(v1::Observation::BLOCK_SELF_JOINT_SPACE);
  observation.add_blocks(v1::Observation::BLOCK_PREVIOUS_TARGET);
  observation.add_blocks(v1::Observation::BLOCK_REFERENCE_DIFFERENCE);
  const bundle::BundleContent content = bundle::testing::ToyLatentContent(
      world::testing::MakeToyWorld(recipe),
      {.self = 33 + 4, .observation = 37 + 35});
  ASSERT_THAT(bundle::WriteBundle(content, options_.bundle), IsOk());

  const auto card = Card();

  ASSERT_THAT(card, IsOk());
  EXPECT_THAT(*card, HasSubstr("```c\nsinew_reset(policy, &state, NULL);"));
}

TEST_F(ModelCardRig, SaysWhichOfSeveralTeachersLabelledWhat) {
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

TEST_F(ModelCardRig, SaysWhatTheClipsWereToTraining) {
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

TEST_F(ModelCardRig, SaysWhereALeftOutClipWasTrainedOn) {
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

TEST_F(ModelCardRig, SaysOfOldBundlesWhatTheirLibraryLeavesOut) {
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

TEST_F(ModelCardRig, AddsUpWhatAProcedureTook) {
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
  const std::string made_it = Path("run/stages/01/config.textproto");
  ASSERT_THAT(WriteFileAtomically(made_it, PrintRecipe(recipe)), IsOk());
  EXPECT_THAT(Card(), StatusIs(absl::StatusCode::kInvalidArgument,
                               AllOf(HasSubstr(options_.run),
                                     HasSubstr("recipe: expected the bundle's"),
                                     HasSubstr("found toy_plus"))));

  ASSERT_THAT(WriteFileAtomically(made_it, PrintRecipe(toy_.recipe)), IsOk());
  const auto card = Card();

  ASSERT_THAT(card, IsOk());
  EXPECT_THAT(*card,
              AllOf(HasSubstr("# toy_plus, toy"), HasSubstr("| seed | 77 |"),
                    HasSubstr("| samples | 2000 |"), HasSubstr("3.00 h"),
                    HasSubstr("| machine | 2 cores, unknown |"),
                    HasSubstr("1. for reason 0\n1. for reason 1\n"),
                    HasSubstr("--recipe toy_plus --character toy")));
}

}  // namespace
}  // namespace sinew::zoo
