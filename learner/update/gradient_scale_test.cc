#include "learner/update/gradient_scale.h"

#include <gtest/gtest.h>

namespace sinew::learner {
namespace {

TEST(GradientScale, LimitsTheNormAndLeavesSmallerOnesAlone) {
  EXPECT_EQ(GradientScale(0, 1), 1);
  EXPECT_EQ(GradientScale(0.5, 1), 1);
  EXPECT_NEAR(4 * GradientScale(4, 1), 1, 1e-6);
  EXPECT_LT(4 * GradientScale(4, 1), 1);
}

}  // namespace
}  // namespace sinew::learner
