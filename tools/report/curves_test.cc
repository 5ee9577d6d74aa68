#include "tools/report/curves.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "tools/report/run_record.h"
#include "tools/report/testing/run_rows.h"

namespace sinew::report {
namespace {

using testing::Rows;
using testing::RowsWithCurriculum;
using ::testing::SizeIs;

TEST(Curves, AreMeansOverNeighbouringRows) {
  const Json curves = TrainingCurves(Rows(3 * kMaxPoints));

  ASSERT_THAT(curves["reward"], SizeIs(kMaxPoints));
  EXPECT_EQ(curves["iteration"][0], 3);  // the last of three
  EXPECT_DOUBLE_EQ(curves["reward"][0].get<double>(), 0.52);
  EXPECT_DOUBLE_EQ(curves["tracking_mm"][0].get<double>(), 50);
  EXPECT_DOUBLE_EQ(curves["fail_share"][0].get<double>(), 0.5);
  EXPECT_DOUBLE_EQ(curves["reward_linear"][0].get<double>(), 0.3);
  // 3000 samples in 6 s.
  EXPECT_DOUBLE_EQ(curves["samples_per_s"][1].get<double>(), 500);
}

TEST(Curves, LeaveOutWhatNoRowHas) {
  std::vector<Json> rows = Rows(3);
  rows[1].erase("kl");
  rows[1]["reward"] = "not a number";

  const Json curves = TrainingCurves(rows);

  EXPECT_FALSE(curves.contains("clip_fraction"));
  EXPECT_TRUE(curves["kl"][1].is_null());
  EXPECT_TRUE(curves["reward"][1].is_null());
  EXPECT_EQ(TrainingCurves({}), Json::object());
}

TEST(Curves, HoldEveryEvaluation) {
  const Json curves = EvaluationCurves(Rows(20));

  EXPECT_EQ(curves["iteration"], Json({5, 10, 15, 20}));
  EXPECT_EQ(curves["succeeded_share"], Json({0.25, 0.25, 0.25, 0.25}));
  EXPECT_FALSE(curves.contains("e_acc"));
  EXPECT_FALSE(curves.contains("left_out_succeeded_share"));
}

TEST(Curves, HoldWhatIsLeftOutOfTraining) {
  std::vector<Json> rows = Rows(5);
  rows[4]["eval"]["left_out"] = {{"starts", 4}, {"succeeded_starts", 3}};

  const Json curves = EvaluationCurves(rows);

  ASSERT_THAT(curves["left_out_succeeded_share"], SizeIs(1));
  EXPECT_EQ(curves["left_out_succeeded_share"][0], 0.75);
}

TEST(Curves, OfTheCurriculumAreThereWhereItHasMoreThanOneBin) {
  const Json curves = CurriculumCurves(RowsWithCurriculum(5));

  ASSERT_THAT(curves["entropy_share"], SizeIs(5));
  EXPECT_EQ(curves["train_s"][4], 7.5);
  EXPECT_DOUBLE_EQ(curves["hardest_share"][0].get<double>(), 0.25);
  EXPECT_TRUE(curves["worst_success"][1].is_null());
  EXPECT_DOUBLE_EQ(curves["worst_success"][2].get<double>(), 0.5);
  EXPECT_FALSE(curves.contains("clips_of_half"));

  std::vector<Json> single = RowsWithCurriculum(2);
  for (Json& row : single) row["curriculum"]["bins"] = 1;
  EXPECT_TRUE(CurriculumCurves(single).empty());
  EXPECT_TRUE(CurriculumCurves(Rows(2)).empty());
  EXPECT_TRUE(CurriculumCurves({}).empty());
}

TEST(Curves, HoldWhatADistillationMeasures) {
  std::vector<Json> rows = Rows(2);
  rows[1]["distillation"] = {{"action_loss", 0.5},
                             {"action_error_rad", 0.0625},
                             {"memory_rows", 4096}};

  const Json curves = TrainingCurves(rows);

  EXPECT_TRUE(curves["action_error_mrad"][0].is_null());
  EXPECT_DOUBLE_EQ(curves["action_error_mrad"][1].get<double>(), 62.5);
  EXPECT_DOUBLE_EQ(curves["action_loss"][1].get<double>(), 0.5);
  EXPECT_DOUBLE_EQ(curves["memory_rows"][1].get<double>(), 4096);
  EXPECT_FALSE(curves.contains("latent_kl"));
  EXPECT_FALSE(TrainingCurves(Rows(2)).contains("action_error_mrad"));
}

TEST(Curves, HoldTheKlOfALatentThatPpoLearns) {
  std::vector<Json> rows = Rows(2);
  rows[1]["latent_kl"] = 2.5;

  const Json curves = TrainingCurves(rows);

  EXPECT_TRUE(curves["latent_kl"][0].is_null());
  EXPECT_DOUBLE_EQ(curves["latent_kl"][1].get<double>(), 2.5);
  EXPECT_FALSE(curves.contains("memory_rows"));
}

}  // namespace
}  // namespace sinew::report
