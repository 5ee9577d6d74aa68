#include "tools/bench/transport_figures.h"

#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::bench {
namespace {

using ::sinew::testing::IsOk;

TEST(TransportFigures, FollowFromBytesAndSeconds) {
  const auto figures = MeasureTransport({.observation_width = 10,
                                         .action_width = 2,
                                         .environments = 2,
                                         .steps = 8,
                                         .orders = 3,
                                         .iterations = 2,
                                         .samples_per_s = 1000});
  ASSERT_THAT(figures, IsOk());

  // Per sample at least observation, action, mean (float32) and target
  // (float64): 4 (10 + 2 + 2) + 8 x 2 bytes.
  EXPECT_GT(figures->bytes_per_sample, 72);
  // 2 iterations of 3 x 2 x 8 samples; a message's size may differ by bytes.
  EXPECT_NEAR(static_cast<double>(figures->bytes),
              96 * figures->bytes_per_sample, 100);
  EXPECT_GT(figures->gb_per_s, 0);
  EXPECT_NEAR(figures->core_share,
              figures->core_s_per_gb * 1e-9 * figures->bytes_per_sample * 1000,
              1e-12);
}

}  // namespace
}  // namespace sinew::bench
