#include "tools/training/shown_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "absl/status/status.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "common/testing/test_files.h"
#include "learner/procedure/procedure.h"
#include "tools/training/procedure_record.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOkAndHolds;
using ::sinew::testing::StatusIs;
using ::sinew::testing::TestPath;
using ::sinew::testing::WriteTestFile;
using ::testing::AllOf;
using ::testing::HasSubstr;

ProcedureRecord TwoStages() {
  ProcedureRecord record;
  for (const char* name : {"00_primitive_0", "01_primitive_0_hard"}) {
    record.stages.emplace_back();
    record.stages.back().directory = JoinPath("stages", name);
    record.stages.back().decision.next = learner::Stage();
  }
  return record;
}

TEST(ShownFolder, IsThatOfTheNewestStageThatHasWhatIsShown) {
  const std::string run = TestPath("run");
  EXPECT_EQ(FolderWithState(run), run);
  EXPECT_EQ(FolderWithRows(run), run);
  WriteTestFile("run/procedure.json", PrintProcedure(TwoStages()));
  const std::string first = JoinPath(run, "stages/00_primitive_0");
  const std::string second = JoinPath(run, "stages/01_primitive_0_hard");
  EXPECT_EQ(FolderWithState(run), second);
  EXPECT_EQ(FolderWithRows(run), second);

  // Between the two stages.
  WriteTestFile("run/stages/00_primitive_0/metrics.jsonl", "{}\n");
  WriteTestFile(
      "run/stages/00_primitive_0/checkpoints/artifacts/state-00000003", "");
  EXPECT_EQ(FolderWithState(run), first);
  EXPECT_EQ(FolderWithRows(run), first);

  // The second has a row, and no state yet.
  WriteTestFile("run/stages/01_primitive_0_hard/metrics.jsonl", "{}\n");
  EXPECT_EQ(FolderWithState(run), first);
  EXPECT_EQ(FolderWithRows(run), second);

  WriteTestFile(
      "run/stages/01_primitive_0_hard/checkpoints/artifacts/state-00000001",
      "");
  EXPECT_EQ(FolderWithState(run), second);
}

TEST(ShownFolder, IsTheRunItselfIfItsRecordIsDamaged) {
  const std::string run = TestPath("run");
  WriteTestFile("run/procedure.json", "{");

  EXPECT_EQ(FolderWithState(run), run);
  EXPECT_EQ(FolderWithRows(run), run);
}

TEST(ShownFolder, ToExportIsARunOrTheStageThatAProcedureCameTo) {
  const std::string run = TestPath("run");
  EXPECT_THAT(FolderToExport(run), IsOkAndHolds(run));
  ProcedureRecord record = TwoStages();
  for (ProcedureRecord::Entry& stage : record.stages) {
    stage.finished = learner::FinishedStage();
    stage.finished->stage = *stage.decision.next;
  }
  // The first fails fewer.
  record.stages[1].finished->failed = {"tumble"};
  record.end = learner::Decision();
  WriteTestFile("run/procedure.json", PrintProcedure(record));

  EXPECT_THAT(FolderToExport(run),
              IsOkAndHolds(JoinPath(run, "stages/00_primitive_0")));
}

TEST(ShownFolder, ToExportWaitsForNoSinglePrimitive) {
  ProcedureRecord record = TwoStages();
  record.stages[0].finished = learner::FinishedStage();
  record.stages[1].directory = "stages/01_single";
  record.stages[1].decision.next->kind = learner::StageKind::kSingle;
  WriteTestFile("run/procedure.json", PrintProcedure(record));

  EXPECT_THAT(FolderToExport(TestPath("run")),
              IsOkAndHolds(JoinPath(TestPath("run"), "stages/00_primitive_0")));
}

TEST(ShownFolder, ToExportIsNoProcedureThatIsNotOver) {
  const std::string run = TestPath("run");
  WriteTestFile("run/procedure.json", PrintProcedure(TwoStages()));
  WriteTestFile(
      "run/stages/00_primitive_0/checkpoints/artifacts/state-00000003", "");

  EXPECT_THAT(
      FolderToExport(run),
      StatusIs(
          absl::StatusCode::kFailedPrecondition,
          AllOf(HasSubstr("found one that is not (0 stages"),
                HasSubstr("--run " + JoinPath(run, "stages/00_primitive_0")))));
  WriteTestFile("run/procedure.json", "{");
  EXPECT_THAT(FolderToExport(run), StatusIs(absl::StatusCode::kDataLoss));
}

}  // namespace
}  // namespace sinew::tools
