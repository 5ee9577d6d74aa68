#include "tools/bench/quantile.h"

#include "gtest/gtest.h"

namespace sinew::bench {
namespace {

TEST(Quantile, IsTheNearestOfTheValues) {
  EXPECT_EQ(Quantile({4, 1, 3, 2, 5}, 0), 1);
  EXPECT_EQ(Quantile({4, 1, 3, 2, 5}, 0.3), 2);  // 1.2 of 0 to 4
  EXPECT_EQ(Quantile({4, 1, 3, 2, 5}, 0.99), 5);
  EXPECT_EQ(Quantile({7}, 0.99), 7);
}

TEST(Median, IsTheMiddleAndTheUpperOfTwo) {
  EXPECT_EQ(Median({9, 1, 5}), 5);
  EXPECT_EQ(Median({9, 1, 5, 7}), 7);
}

}  // namespace
}  // namespace sinew::bench
