#include "tools/bench/teacher_figures.h"

#include "common/config/recipe.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::bench {
namespace {

using ::sinew::testing::IsOk;

TEST(TeacherFigures, FollowFromRowsAndSeconds) {
  TeacherOptions options = {.observation_width = 10,
                            .action_width = 2,
                            .network = WithDefaults(v1::Recipe()).network(),
                            .rows = 300,
                            .rounds = 1,
                            .calls = 5};
  options.network.clear_policy_hidden();
  options.network.add_policy_hidden(16);

  const auto figures = MeasureTeacher(options);
  ASSERT_THAT(figures, IsOk());

  EXPECT_GT(figures->rows_per_s, 0);
  // Of one round all three say the same.
  EXPECT_NEAR(figures->throughput_ratio,
              figures->rows_per_s / figures->executor_rows_per_s,
              1e-9 * figures->throughput_ratio);
  EXPECT_GT(figures->latency_p50_ms, 0);
  EXPECT_GE(figures->latency_p99_ms, figures->latency_p50_ms);
}

}  // namespace
}  // namespace sinew::bench
