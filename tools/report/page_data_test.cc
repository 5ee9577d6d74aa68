#include "tools/report/page_data.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/report/run_record.h"
#include "tools/report/testing/run_rows.h"

namespace sinew::report {
namespace {

using testing::Rows;
using testing::RowsWithCurriculum;
using ::testing::SizeIs;

TEST(PageData, HasTheCurriculumOfARunOfManyBins) {
  RunRecord run;
  run.rows = RowsWithCurriculum(3);
  PageContext context;
  context.curriculum = {{"rule", "adaptive_bins"}};

  const Json curriculum = MakePageData(run, context)["curriculum"];
  EXPECT_EQ(curriculum["rule"], "adaptive_bins");
  EXPECT_THAT(curriculum["curves"]["entropy_share"], SizeIs(3));

  run.rows = Rows(3);
  EXPECT_TRUE(MakePageData(run, context)["curriculum"].is_null());
}

TEST(PageData, TakesTheResultFromTheEvaluationElseFromTraining) {
  RunRecord run;
  run.directory = "runs/it";
  run.rows = Rows(10);

  Json head = MakePageData(run, {})["headline"];
  EXPECT_EQ(head["source"], "training");
  EXPECT_EQ(head["succeeded_starts"], 8);
  EXPECT_DOUBLE_EQ(head["minutes"].get<double>(), 0.25);

  run.evaluation = {{"overall", {{"starts", 32}, {"succeeded_starts", 31}}},
                    {"zero_action", {{"succeeded_starts", 1}}},
                    {"seconds", 10}};
  head = MakePageData(run, {})["headline"];
  EXPECT_EQ(head["source"], "eval.json");
  EXPECT_EQ(head["succeeded_starts"], 31);
  EXPECT_EQ(head["zero_action"]["succeeded_starts"], 1);

  // Whatever a file of that name holds.
  run.evaluation = {{"overall", 3}};
  EXPECT_EQ(MakePageData(run, {})["headline"]["source"], "training");
}

}  // namespace
}  // namespace sinew::report
