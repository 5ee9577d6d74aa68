#include "sim/metrics/diversity.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "absl/status/status.h"
#include "common/stop.h"
#include "common/testing/matchers.h"

namespace sinew::metrics {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;

// Two points, both `offset` m along x at frames 1 and 2; the root ends at
// (root_x, 0).
PosePath Path(float first, float second, float root_x) {
  return {.points = {0, 0, 0, 0, 0, 1,          //
                     first, 0, 0, first, 0, 1,  //
                     second, 0, 0, second, 0, 1},
          .root = {0, 0, 0, 0, root_x, 0}};
}

TEST(Diversity, IsZeroForMotionsThatAreAlike) {
  DiversityMeter meter;

  ASSERT_THAT(meter.AddGroup({Path(1, 2, 3), Path(1, 2, 3)}), IsOk());

  EXPECT_EQ(meter.figures().pairs, 1);
  EXPECT_EQ(meter.figures().over_time_m, 0);
  EXPECT_EQ(meter.figures().final_m, 0);
  EXPECT_EQ(meter.figures().final_root_m, 0);
}

TEST(Diversity, IsTheMeanOverPairsOfTheMeanOverTime) {
  DiversityMeter meter;

  // Pairs differ by 1 and 3; 2 and 2; 1 and 1 m: over time 2, 2 and 1.
  ASSERT_THAT(meter.AddGroup({Path(0, 0, 0), Path(1, 3, 6), Path(2, 2, 0)}),
              IsOk());

  const DiversityFigures figures = meter.figures();
  EXPECT_EQ(figures.pairs, 3);
  EXPECT_NEAR(figures.over_time_m, 5.0 / 3, 1e-6);
  EXPECT_NEAR(figures.final_m, 2, 1e-6);       // 3, 2, 1
  EXPECT_NEAR(figures.final_root_m, 4, 1e-6);  // 6, 0, 6
}

TEST(Diversity, ComparesNothingAcrossStarts) {
  DiversityMeter meter;

  ASSERT_THAT(meter.AddGroup({Path(0, 0, 0)}), IsOk());
  ASSERT_THAT(meter.AddGroup({Path(9, 9, 9)}), IsOk());

  EXPECT_EQ(meter.figures().pairs, 0);
}

TEST(Diversity, UsesTheFramesThatBothHave) {
  DiversityMeter meter;
  PosePath cut = Path(0, 0, 0);
  cut.points.resize(12);
  cut.root.resize(4);

  ASSERT_THAT(meter.AddGroup({Path(1, 100, 100), cut}), IsOk());

  EXPECT_NEAR(meter.figures().over_time_m, 1, 1e-6);
  EXPECT_NEAR(meter.figures().final_m, 1, 1e-6);
  EXPECT_NEAR(meter.figures().final_root_m, 0, 1e-6);
}

TEST(Diversity, StopsWhenItIsAskedTo) {
  DiversityMeter meter;
  StopSource source;
  source.request_stop();

  EXPECT_THAT(
      meter.AddGroup({Path(1, 2, 3), Path(1, 2, 3)}, source.get_token()),
      StatusIs(absl::StatusCode::kCancelled));
}

}  // namespace
}  // namespace sinew::metrics
