#include "tools/training/metrics_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/strings/str_split.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "common/testing/test_files.h"
#include "proto/sinew/v1/training_state.pb.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::TestPath;
using ::testing::ElementsAre;
using Json = nlohmann::json;

// Where there is no log yet.
std::string NewLog() {
  EXPECT_THAT(RemoveRecursively(TestPath("run")), IsOk());
  EXPECT_THAT(MakeDirectories(TestPath("run")), IsOk());
  return TestPath("run/metrics.jsonl");
}

void WriteRows(MetricsLog& log, int first, int last) {
  for (int i = first; i <= last; ++i) {
    learner::IterationReport report;
    report.iteration = i;
    EXPECT_THAT(log.Write(report, RunFigures()), IsOk());
  }
}

std::vector<Json> Rows(const std::string& path) {
  std::vector<Json> rows;
  const auto text = ReadFile(path);
  EXPECT_THAT(text, IsOk());
  for (const std::string& line : std::vector<std::string>(
           absl::StrSplit(*text, '\n', absl::SkipEmpty()))) {
    rows.push_back(Json::parse(line));
  }
  return rows;
}

std::vector<int> Iterations(const std::string& path) {
  std::vector<int> iterations;
  for (const Json& row : Rows(path)) iterations.push_back(row.at("iteration"));
  return iterations;
}

// The rows of such reports; null where one is missing.
std::vector<Json> RowsOf(const std::vector<learner::IterationReport>& reports,
                         const RunFigures& figures = RunFigures()) {
  const std::string path = NewLog();
  const auto log = MetricsLog::Open(path, 0);
  EXPECT_THAT(log, IsOk());
  for (const learner::IterationReport& report : reports) {
    EXPECT_THAT((*log)->Write(report, figures), IsOk());
  }
  std::vector<Json> rows = Rows(path);
  EXPECT_EQ(rows.size(), reports.size());
  rows.resize(reports.size());
  return rows;
}

TEST(MetricsLogTest, RemovesRowsPastTheIterationThatIsGoneOnFrom) {
  const std::string path = NewLog();
  auto log = MetricsLog::Open(path, 0);
  ASSERT_THAT(log, IsOk());
  WriteRows(**log, 1, 4);

  log = MetricsLog::Open(path, 2);
  ASSERT_THAT(log, IsOk());
  WriteRows(**log, 3, 3);

  EXPECT_THAT(Iterations(path), ElementsAre(1, 2, 3));
}

TEST(MetricsLogTest, RemovesAnUnfinishedRow) {
  const std::string path = NewLog();
  auto log = MetricsLog::Open(path, 0);
  ASSERT_THAT(log, IsOk());
  WriteRows(**log, 1, 2);
  ASSERT_THAT(AppendToFile(path, "{\"iteration\":3,\"wal"), IsOk());

  ASSERT_THAT(MetricsLog::Open(path, 3), IsOk());

  EXPECT_THAT(Iterations(path), ElementsAre(1, 2));
}

TEST(MetricsLogTest, SaysWhereCoreSecondsWent) {
  learner::IterationReport report;
  report.learn_seconds = 0.25;
  report.rollout_seconds.set_simulate(1.5);
  report.evaluation = EvaluationSummary();
  report.evaluation->overall.starts = 32;
  report.evaluation->overall.succeeded_starts = 12;
  RunFigures figures;
  figures.cores = 2;
  figures.iteration_wall = 1.25;

  const Json row = RowsOf({report}, figures)[0];

  EXPECT_EQ(row["cores"], 2);
  EXPECT_EQ(row["seconds"]["iteration"], 1.25);
  EXPECT_EQ(row["seconds"]["learn"], 0.25);
  EXPECT_EQ(row["seconds"]["simulate"], 1.5);
  EXPECT_EQ(row["eval"]["starts"], 32);
  EXPECT_EQ(row["eval"]["succeeded_starts"], 12);
}

TEST(MetricsLogTest, HasNoErrorOfWhatWasNotMeasured) {
  learner::IterationReport none;
  none.evaluation = EvaluationSummary();
  learner::IterationReport some = none;
  some.iteration = 1;
  some.evaluation->overall.frames = 2;
  some.evaluation->overall.means = {
      .e_g_mpjpe_mm = 30, .e_vel = 4, .velocity_frames = 1};

  const std::vector<Json> rows = RowsOf({none, some});

  for (const char* error : {"e_g_mpjpe_mm", "e_mpjpe_mm", "e_vel", "e_acc"}) {
    EXPECT_TRUE(rows[0]["eval"].at(error).is_null()) << error;
  }
  EXPECT_EQ(rows[1]["eval"]["e_g_mpjpe_mm"], 30);
  EXPECT_EQ(rows[1]["eval"]["e_vel"], 4);
  EXPECT_TRUE(rows[1]["eval"]["e_acc"].is_null());  // takes three in a row
}

TEST(MetricsLogTest, SaysWhereEpisodesStart) {
  learner::IterationReport all;
  all.curriculum.bins = 7;
  all.curriculum.entropy_share = 0.5;
  all.curriculum.hard_clips = 2;
  all.evaluation = EvaluationSummary();
  all.evaluation->training.clips = 4;
  learner::IterationReport some = all;
  some.evaluation->left_out.clips = 3;

  const std::vector<Json> rows = RowsOf({all, some});

  EXPECT_EQ(rows[0]["curriculum"]["bins"], 7);
  EXPECT_EQ(rows[0]["curriculum"]["entropy_share"], 0.5);
  EXPECT_EQ(rows[0]["curriculum"]["hard_clips"], 2);
  EXPECT_FALSE(rows[0]["eval"].contains("left_out"));
  EXPECT_EQ(rows[1]["eval"]["training"]["clips"], 4);
  EXPECT_EQ(rows[1]["eval"]["left_out"]["clips"], 3);
}

TEST(MetricsLogTest, HasThePlateauOnlyWhereTheRecipeHasOne) {
  learner::IterationReport with;
  with.plateau = v1::PlateauState();
  with.plateau->set_best_share(0.75);
  with.plateau->set_stalled(2);

  const std::vector<Json> rows = RowsOf({learner::IterationReport(), with});

  EXPECT_FALSE(rows[0].contains("plateau"));
  EXPECT_EQ(rows[1]["plateau"]["best_share"], 0.75);
  EXPECT_EQ(rows[1]["plateau"]["stalled"], 2);
}

TEST(MetricsLogTest, HasTheDistillationOnlyWhereTheRecipeHasOne) {
  learner::IterationReport with;
  with.label_seconds = 0.25;
  with.update.distillation = learner::DistillationFigures();
  with.update.distillation->action_error_rad = 0.125;
  with.update.distillation->memory_rows = 4096;

  const std::vector<Json> rows = RowsOf({learner::IterationReport(), with});

  EXPECT_FALSE(rows[0].contains("distillation"));
  EXPECT_EQ(rows[1]["distillation"]["action_error_rad"], 0.125);
  EXPECT_EQ(rows[1]["distillation"]["memory_rows"], 4096);
  EXPECT_EQ(rows[1]["seconds"]["label"], 0.25);
}

TEST(MetricsLogTest, HasTheKlOfALatentOnlyWherePpoLearnsOne) {
  learner::IterationReport with;
  with.update.latent_kl = 0.75;

  const std::vector<Json> rows = RowsOf({learner::IterationReport(), with});

  EXPECT_FALSE(rows[0].contains("latent_kl"));
  EXPECT_EQ(rows[1]["latent_kl"], 0.75);
}

TEST(MetricsLogTest, HasTheClipsThatAreDrawnFromWhereTheyAreFewer) {
  learner::IterationReport all;
  all.evaluation = EvaluationSummary();
  all.evaluation->training.clips = 4;
  all.drawn.clips = 4;
  learner::IterationReport fewer = all;
  fewer.drawn.clips = 3;
  fewer.drawn.succeeded_starts = 7;

  const std::vector<Json> rows = RowsOf({all, fewer});

  EXPECT_FALSE(rows[0]["eval"].contains("drawn"));
  EXPECT_EQ(rows[1]["eval"]["drawn"]["clips"], 3);
  EXPECT_EQ(rows[1]["eval"]["drawn"]["succeeded_starts"], 7);
}

}  // namespace
}  // namespace sinew::tools
