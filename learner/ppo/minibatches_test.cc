#include "learner/ppo/minibatches.h"

#include <algorithm>
#include <map>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::learner {
namespace {

std::vector<int64_t> Shuffled(uint64_t seed, int64_t iteration, int epoch,
                              size_t size) {
  std::vector<int64_t> order(size);
  ShuffleRows(seed, iteration, epoch, order);
  return order;
}

TEST(ShuffleRows, GivesEveryRowOnce) {
  for (size_t size : {0, 1, 2, 1000}) {
    std::vector<int64_t> order = Shuffled(1, 2, 3, size);
    std::sort(order.begin(), order.end());
    for (size_t i = 0; i < size; ++i) EXPECT_EQ(order[i], i);
  }
}

TEST(ShuffleRows, IsAFunctionOfItsKey) {
  EXPECT_EQ(Shuffled(1, 2, 3, 100), Shuffled(1, 2, 3, 100));
  EXPECT_NE(Shuffled(1, 2, 3, 100), Shuffled(9, 2, 3, 100));
  EXPECT_NE(Shuffled(1, 2, 3, 100), Shuffled(1, 9, 3, 100));
  EXPECT_NE(Shuffled(1, 2, 3, 100), Shuffled(1, 2, 9, 100));
}

TEST(ShuffleRows, FindsAllOrdersEquallyOften) {
  std::map<std::vector<int64_t>, int> counts;
  for (int iteration = 0; iteration < 6000; ++iteration) {
    ++counts[Shuffled(5, iteration, 0, 3)];
  }
  ASSERT_EQ(counts.size(), 6);
  // 1000 expected, standard deviation sqrt(6000 * 1/6 * 5/6) = 29.
  for (const auto& [order, count] : counts) EXPECT_NEAR(count, 1000, 120);
}

}  // namespace
}  // namespace sinew::learner
