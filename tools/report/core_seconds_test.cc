#include "tools/report/core_seconds.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "tools/report/run_record.h"
#include "tools/report/testing/run_rows.h"

namespace sinew::report {
namespace {

using testing::Rows;
using ::testing::SizeIs;

std::map<std::string, double> SecondsOf(const CoreSeconds& counted) {
  std::map<std::string, double> seconds;
  for (const Stage& stage : counted.stages) seconds[stage.name] = stage.seconds;
  return seconds;
}

TEST(CoreSeconds, AddUpToCoresTimesWallTime) {
  const CoreSeconds counted = CountCoreSeconds(Rows(10));

  // 2 cores x 20 s; learning is 10 x 0.5 s on 2 ranks; the rest is idle.
  EXPECT_DOUBLE_EQ(counted.total, 40);
  std::map<std::string, double> seconds = SecondsOf(counted);
  EXPECT_DOUBLE_EQ(seconds["simulate"], 15);
  EXPECT_DOUBLE_EQ(seconds["infer"], 2.5);
  EXPECT_DOUBLE_EQ(seconds["learn"], 10);
  EXPECT_DOUBLE_EQ(seconds["wait"], 12.5);
  EXPECT_THAT(seconds, SizeIs(4));
}

TEST(CoreSeconds, HoldAllCoresWhileLabelsAreWaitedFor) {
  std::vector<Json> rows = Rows(10);
  for (Json& row : rows) row["seconds"]["label"] = 0.25;

  const CoreSeconds counted = CountCoreSeconds(rows);

  // 10 x 0.25 s of wall time on 2 cores, less of "wait".
  std::map<std::string, double> seconds = SecondsOf(counted);
  EXPECT_DOUBLE_EQ(seconds["label"], 5);
  EXPECT_DOUBLE_EQ(seconds["wait"], 7.5);
  EXPECT_DOUBLE_EQ(counted.total, 40);
}

TEST(CoreSeconds, GuessTheCoresOfRowsThatDoNotSay) {
  std::vector<Json> rows = Rows(10);
  for (Json& row : rows) {
    row.erase("cores");
    row.erase("ranks");
    row["seconds"]["wait"] = 0.9;  // 1.75 busy seconds meanwhile
  }

  EXPECT_DOUBLE_EQ(CountCoreSeconds(rows).cores, 2);
  EXPECT_DOUBLE_EQ(CountCoreSeconds({}).total, 0);
}

}  // namespace
}  // namespace sinew::report
