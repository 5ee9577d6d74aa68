// What a procedure refuses, and that nothing is lost by it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "common/evaluation/evaluation_summary.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "tools/training/procedure_record.h"
#include "tools/training/procedure_run.h"
#include "tools/training/testing/procedure_rig.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Optional;
using ::testing::Pair;
using ::testing::SizeIs;

TEST_F(ProcedureRunTest, PassesOnWhatATrainingFailedWith) {
  MadeUpSteps steps;
  ProcedureSteps failing = steps.Steps();
  failing.train = [](const TrainingRun::Options&) {
    return absl::InternalError("no actors");
  };

  EXPECT_THAT(RunProcedure(options_, failing, steps.token()),
              StatusIs(absl::StatusCode::kInternal, HasSubstr("no actors")));

  ASSERT_THAT(Run(steps), IsOk());
  EXPECT_EQ(File("bundle/weights"), kComposed);
}

TEST_F(ProcedureRunTest, RefusesALibraryThatIsNotClean) {
  const std::string file = JoinPath(toy_.library_folder, "manifest.json");
  auto manifest = nlohmann::json::parse(*ReadFile(file));
  manifest["clips"][1]["quality"]["penetration_max_m"] = 0.25;
  ASSERT_THAT(WriteFileAtomically(file, manifest.dump()), IsOk());
  MadeUpSteps steps;

  EXPECT_THAT(Run(steps),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       AllOf(HasSubstr("clip \"sway\": largest depth below "
                                       "the floor 25 cm, limit 10"),
                             HasSubstr("import the library again"))));

  EXPECT_THAT(steps.trained(), IsEmpty());
}

TEST_F(ProcedureRunTest, SaysWhatWasCleanedAwayAndWhy) {
  MadeUpSteps some(2), others;
  ASSERT_THAT(Run(some), IsOk());
  EXPECT_EQ(Record().cleaned_away, std::nullopt);  // no report: not known
  UseRun("other");
  ASSERT_THAT(
      WriteFileAtomically(JoinPath(toy_.library_folder, "report.json"), R"(
          {"clips": [{"name": "turn", "status": "ok", "frames": 30},
                     {"name": "sway", "status": "ok", "frames": 30},
                     {"name": "tumble", "status": "ok", "frames": 30},
                     {"name": "fly", "status": "rejected", "frames": 30,
                      "reason": "no floor"}]})"),
      IsOk());

  ASSERT_THAT(Run(others), IsOk());

  EXPECT_THAT(Record().cleaned_away,
              Optional(ElementsAre(Pair("fly", "no floor"))));
}

TEST_F(ProcedureRunTest, RefusesAnotherRecipe) {
  MadeUpSteps steps(2);
  ASSERT_THAT(Run(steps), IsOk());
  options_.recipe.mutable_procedure()->set_hard_samples(6400);

  EXPECT_THAT(Run(steps), StatusIs(absl::StatusCode::kInvalidArgument,
                                   AllOf(HasSubstr("procedure.hard_samples"),
                                         HasSubstr("320 -> 6400"))));
}

// The first stage has a state, and what that was made from is on record.
TEST_F(ProcedureRunTest, RefusesAnotherInitWithinItsFirstStage) {
  GiveInit("first");
  MadeUpSteps none(0), none_again(0), steps;
  ASSERT_THAT(Run(none), IsOk());
  GiveInit("second");
  ASSERT_THAT(Run(none_again), IsOk());  // nothing was trained: it begins anew
  const std::string states = JoinPath(
      options_.directory, "stages/00_primitive_0/checkpoints/artifacts");
  ASSERT_THAT(MakeDirectories(states), IsOk());
  ASSERT_THAT(WriteFileAtomically(JoinPath(states, "state-00000001"), ""),
              IsOk());

  for (const std::string& init :
       {JoinPath(toy_.folder, "first"), std::string()}) {
    options_.init = init;
    EXPECT_THAT(Run(steps), StatusIs(absl::StatusCode::kFailedPrecondition,
                                     HasSubstr("changed: init)")));
  }
  EXPECT_THAT(steps.trained(), IsEmpty());

  GiveInit("second");
  EXPECT_THAT(Run(steps), IsOk());
}

TEST_F(ProcedureRunTest, AsksNoMoreForItsInitOnceTheFirstStageHasEnded) {
  GiveInit("given");
  MadeUpSteps first(2), rest;
  ASSERT_THAT(Run(first), IsOk());
  EXPECT_THAT(Record().Finished(), SizeIs(1));

  options_.init = JoinPath(toy_.folder, "gone");
  EXPECT_THAT(Run(rest), IsOk());
}

// Not after the stages that come before the one that recovers.
TEST_F(ProcedureRunTest, RefusesALibraryWithoutTheGetUpThatRecoveryNeeds) {
  options_.recipe.mutable_task()->mutable_recovery()->set_get_up_share(0.3);
  MadeUpSteps steps;

  EXPECT_THAT(Run(steps),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr(toy_.library_folder),
                             HasSubstr("task.recovery.get_up_share"))));
  EXPECT_THAT(steps.trained(), IsEmpty());
}

TEST_F(ProcedureRunTest, NamesAnInitThatIsNoBundle) {
  options_.init = JoinPath(toy_.folder, "nowhere");
  MadeUpSteps steps;

  EXPECT_THAT(Run(steps), StatusIs(absl::StatusCode::kNotFound,
                                   HasSubstr("nowhere/manifest.json")));
}

TEST_F(ProcedureRunTest, RefusesALibraryThatChangesWhileItRuns) {
  MadeUpSteps steps;
  steps.SetAfterTrain([this] { LeaveOutTumble(); });

  EXPECT_THAT(Run(steps), StatusIs(absl::StatusCode::kFailedPrecondition,
                                   AllOf(HasSubstr(toy_.library_folder),
                                         HasSubstr("changed: library)"))));

  EXPECT_THAT(steps.trained(), SizeIs(1));
  EXPECT_THAT(Record().Finished(), IsEmpty());
}

TEST_F(ProcedureRunTest, RefusesResultsOfClipsThatItDoesNotKnow) {
  MadeUpSteps steps;
  ProcedureSteps more = steps.Steps();
  more.evaluate = [](const auto&, const auto&, const auto&, const auto&) {
    evaluation::EvaluationFigures figures;
    figures.policy.clips.resize(1);
    figures.policy.clips[0].clip = 3;
    return absl::StatusOr<evaluation::EvaluationFigures>(figures);
  };

  EXPECT_THAT(
      RunProcedure(options_, more, steps.token()),
      StatusIs(absl::StatusCode::kFailedPrecondition,
               AllOf(HasSubstr("the 3 clips"), HasSubstr("found clip 3"))));
}

TEST_F(ProcedureRunTest, TakesACorrectedRecipeIfNothingWasTrained) {
  MadeUpSteps none(0), steps;
  options_.recipe.mutable_task()->mutable_start()->add_only_clips("swai");
  EXPECT_THAT(Run(none),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("only_clips"), HasSubstr("\"sway\""))));
  options_.recipe.mutable_task()->mutable_start()->clear_only_clips();
  options_.recipe.mutable_procedure()->set_full_samples(6400);
  ASSERT_THAT(Run(none), IsOk());  // stopped before its first state
  ASSERT_THAT(Record().stages, SizeIs(1));
  options_.recipe.mutable_procedure()->set_full_samples(640);

  ASSERT_THAT(Run(steps), IsOk());

  EXPECT_EQ(File("bundle/weights"), kComposed);
}

TEST_F(ProcedureRunTest, RefusesAnotherLibrary) {
  MadeUpSteps steps(2);
  ASSERT_THAT(Run(steps), IsOk());
  LeaveOutTumble();

  EXPECT_THAT(Run(steps), StatusIs(absl::StatusCode::kFailedPrecondition,
                                   AllOf(HasSubstr(options_.directory),
                                         HasSubstr("changed: library)"))));
}

TEST_F(ProcedureRunTest, RefusesToMigrate) {
  options_.migrate_library = true;
  MadeUpSteps steps;

  EXPECT_THAT(Run(steps), StatusIs(absl::StatusCode::kInvalidArgument,
                                   HasSubstr("--migrate-library")));
}

TEST_F(ProcedureRunTest, RefusesPrimitivesFromElsewhere) {
  options_.primitives = {"a", "b"};
  MadeUpSteps steps;

  EXPECT_THAT(Run(steps), StatusIs(absl::StatusCode::kInvalidArgument,
                                   HasSubstr("--primitives")));
  EXPECT_THAT(steps.trained(), IsEmpty());
}

TEST_F(ProcedureRunTest, RefusesATeacher) {
  MadeUpSteps steps;
  options_.teachers = {"bundles/expert"};
  EXPECT_THAT(Run(steps), StatusIs(absl::StatusCode::kInvalidArgument,
                                   HasSubstr("--teacher: expected")));
  options_.teachers.clear();
  options_.teacher_evaluations = {"expert.json"};
  EXPECT_THAT(Run(steps), StatusIs(absl::StatusCode::kInvalidArgument,
                                   HasSubstr("--teacher-eval: expected")));
  EXPECT_THAT(steps.trained(), IsEmpty());
}

TEST_F(ProcedureRunTest, RefusesACompactState) {
  options_.continue_from = "states/expert";
  MadeUpSteps steps;

  EXPECT_THAT(Run(steps), StatusIs(absl::StatusCode::kInvalidArgument,
                                   HasSubstr("--continue")));
  EXPECT_THAT(steps.trained(), IsEmpty());
}

TEST_F(ProcedureRunTest, RefusesARecordThatDoesNotFollow) {
  MadeUpSteps steps(3);
  ASSERT_THAT(Run(steps), IsOk());
  ProcedureRecord record = Record();
  record.stages[0].finished->failed = {"turn"};
  ASSERT_THAT(
      WriteFileAtomically(JoinPath(options_.directory, "procedure.json"),
                          PrintProcedure(record)),
      IsOk());

  MadeUpSteps fresh;
  EXPECT_THAT(Run(fresh), StatusIs(absl::StatusCode::kDataLoss,
                                   HasSubstr("01_primitive_0_hard")));
}

}  // namespace
}  // namespace sinew::tools
