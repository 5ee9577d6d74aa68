#include "tools/training/metrics_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/strings/str_split.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "proto/sinew/v1/training_state.pb.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::testing::ElementsAre;

std::string NewFile(const std::string& name) {
  return JoinPath(getenv("TEST_TMPDIR"), name);
}

void WriteRows(MetricsLog& log, int first, int last) {
  for (int i = first; i <= last; ++i) {
    learner::IterationReport report;
    report.iteration = i;
    EXPECT_THAT(log.Write(report, RunFigures()), IsOk());
  }
}

std::vector<int> Iterations(const std::string& path) {
  std::vector<int> iterations;
  const auto text = ReadFile(path);
  EXPECT_THAT(text, IsOk());
  for (const std::string& line : std::vector<std::string>(
           absl::StrSplit(*text, '\n', absl::SkipEmpty()))) {
    iterations.push_back(nlohmann::json::parse(line).at("iteration"));
  }
  return iterations;
}

TEST(MetricsLogTest, RemovesRowsPastTheIterationThatIsGoneOnFrom) {
  const std::string path = NewFile("past.jsonl");
  auto log = MetricsLog::Open(path, 0);
  ASSERT_THAT(log, IsOk());
  WriteRows(**log, 1, 4);

  log = MetricsLog::Open(path, 2);
  ASSERT_THAT(log, IsOk());
  WriteRows(**log, 3, 3);

  EXPECT_THAT(Iterations(path), ElementsAre(1, 2, 3));
}

TEST(MetricsLogTest, RemovesAnUnfinishedRow) {
  const std::string path = NewFile("unfinished.jsonl");
  auto log = MetricsLog::Open(path, 0);
  ASSERT_THAT(log, IsOk());
  WriteRows(**log, 1, 2);
  ASSERT_THAT(AppendToFile(path, "{\"iteration\":3,\"wal"), IsOk());

  ASSERT_THAT(MetricsLog::Open(path, 3), IsOk());

  EXPECT_THAT(Iterations(path), ElementsAre(1, 2));
}

TEST(MetricsLogTest, SaysWhereCoreSecondsWent) {
  const std::string path = NewFile("seconds.jsonl");
  auto log = MetricsLog::Open(path, 0);
  ASSERT_THAT(log, IsOk());
  learner::IterationReport report;
  report.iteration = 1;
  report.learn_seconds = 0.25;
  report.rollout_seconds.set_simulate(1.5);
  report.evaluation = EvaluationSummary();
  report.evaluation->overall.starts = 32;
  report.evaluation->overall.succeeded_starts = 12;
  RunFigures figures;
  figures.cores = 2;
  figures.iteration_wall = 1.25;

  ASSERT_THAT((*log)->Write(report, figures), IsOk());

  const auto text = ReadFile(path);
  ASSERT_THAT(text, IsOk());
  const auto row = nlohmann::json::parse(*text);
  EXPECT_EQ(row["cores"], 2);
  EXPECT_EQ(row["seconds"]["iteration"], 1.25);
  EXPECT_EQ(row["seconds"]["learn"], 0.25);
  EXPECT_EQ(row["seconds"]["simulate"], 1.5);
  EXPECT_EQ(row["eval"]["starts"], 32);
  EXPECT_EQ(row["eval"]["succeeded_starts"], 12);
}

TEST(MetricsLogTest, SaysWhereEpisodesStart) {
  const std::string path = NewFile("curriculum.jsonl");
  auto log = MetricsLog::Open(path, 0);
  ASSERT_THAT(log, IsOk());
  learner::IterationReport report;
  report.iteration = 1;
  report.curriculum.bins = 7;
  report.curriculum.entropy_share = 0.5;
  report.curriculum.hard_clips = 2;
  report.evaluation = EvaluationSummary();
  report.evaluation->training.clips = 4;
  ASSERT_THAT((*log)->Write(report, RunFigures()), IsOk());
  report.evaluation->left_out.clips = 3;
  ASSERT_THAT((*log)->Write(report, RunFigures()), IsOk());

  const auto text = ReadFile(path);
  ASSERT_THAT(text, IsOk());
  const std::vector<std::string> lines =
      absl::StrSplit(*text, '\n', absl::SkipEmpty());
  ASSERT_EQ(lines.size(), 2u);
  const auto first = nlohmann::json::parse(lines[0]);
  const auto second = nlohmann::json::parse(lines[1]);
  EXPECT_EQ(first["curriculum"]["bins"], 7);
  EXPECT_EQ(first["curriculum"]["entropy_share"], 0.5);
  EXPECT_EQ(first["curriculum"]["hard_clips"], 2);
  EXPECT_FALSE(first["eval"].contains("left_out"));
  EXPECT_EQ(second["eval"]["training"]["clips"], 4);
  EXPECT_EQ(second["eval"]["left_out"]["clips"], 3);
}

std::vector<nlohmann::json> Rows(const std::string& path) {
  std::vector<nlohmann::json> rows;
  const auto text = ReadFile(path);
  EXPECT_THAT(text, IsOk());
  for (const std::string& line : std::vector<std::string>(
           absl::StrSplit(*text, '\n', absl::SkipEmpty()))) {
    rows.push_back(nlohmann::json::parse(line));
  }
  return rows;
}

TEST(MetricsLogTest, HasThePlateauOnlyWhereTheRecipeHasOne) {
  const std::string path = NewFile("plateau.jsonl");
  auto log = MetricsLog::Open(path, 0);
  ASSERT_THAT(log, IsOk());
  learner::IterationReport report;
  report.iteration = 1;
  ASSERT_THAT((*log)->Write(report, RunFigures()), IsOk());
  report.iteration = 2;
  report.plateau = v1::PlateauState();
  report.plateau->set_best_share(0.75);
  report.plateau->set_stalled(2);
  ASSERT_THAT((*log)->Write(report, RunFigures()), IsOk());

  const std::vector<nlohmann::json> rows = Rows(path);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_FALSE(rows[0].contains("plateau"));
  EXPECT_EQ(rows[1]["plateau"]["best_share"], 0.75);
  EXPECT_EQ(rows[1]["plateau"]["stalled"], 2);
}

TEST(MetricsLogTest, HasTheDistillationOnlyWhereTheRecipeHasOne) {
  const std::string path = NewFile("distillation.jsonl");
  auto log = MetricsLog::Open(path, 0);
  ASSERT_THAT(log, IsOk());
  learner::IterationReport report;
  report.iteration = 1;
  ASSERT_THAT((*log)->Write(report, RunFigures()), IsOk());
  report.iteration = 2;
  report.label_seconds = 0.25;
  report.update.distillation = learner::DistillationFigures();
  report.update.distillation->action_error_rad = 0.125;
  report.update.distillation->memory_rows = 4096;
  ASSERT_THAT((*log)->Write(report, RunFigures()), IsOk());

  const std::vector<nlohmann::json> rows = Rows(path);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_FALSE(rows[0].contains("distillation"));
  EXPECT_EQ(rows[1]["distillation"]["action_error_rad"], 0.125);
  EXPECT_EQ(rows[1]["distillation"]["memory_rows"], 4096);
  EXPECT_EQ(rows[1]["seconds"]["label"], 0.25);
}

TEST(MetricsLogTest, HasTheClipsThatAreDrawnFromWhereTheyAreFewer) {
  const std::string path = NewFile("drawn.jsonl");
  auto log = MetricsLog::Open(path, 0);
  ASSERT_THAT(log, IsOk());
  learner::IterationReport report;
  report.iteration = 1;
  report.evaluation = EvaluationSummary();
  report.evaluation->training.clips = 4;
  report.drawn.clips = 4;
  ASSERT_THAT((*log)->Write(report, RunFigures()), IsOk());
  report.iteration = 2;
  report.drawn.clips = 3;
  report.drawn.succeeded_starts = 7;
  ASSERT_THAT((*log)->Write(report, RunFigures()), IsOk());

  const std::vector<nlohmann::json> rows = Rows(path);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_FALSE(rows[0]["eval"].contains("drawn"));
  EXPECT_EQ(rows[1]["eval"]["drawn"]["clips"], 3);
  EXPECT_EQ(rows[1]["eval"]["drawn"]["succeeded_starts"], 7);
}

}  // namespace
}  // namespace sinew::tools
