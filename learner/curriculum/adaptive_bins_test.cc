#include "learner/curriculum/adaptive_bins.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/random/philox.h"

namespace sinew::learner {
namespace {

using ::testing::DoubleEq;
using ::testing::ElementsAre;

TEST(LimitClips, GivesAClipTheLargerOfItsTwoFloors) {
  // Even share 1/5; by frames 0.1 * 0.96 for the long clip.
  const auto limits = LimitClips({960, 10, 10, 10, 10}, 0.1, 0.1, 0.5);

  EXPECT_DOUBLE_EQ(limits[0].floor_share, 0.096);
  EXPECT_DOUBLE_EQ(limits[1].floor_share, 0.02);
  EXPECT_DOUBLE_EQ(limits[0].cap, 0.5);
}

TEST(LimitClips, ScalesFloorsThatAskForMoreThanOne) {
  // 0.7 by frames, and 0.25 each as clips: 0.7 + 3 * 0.25 = 1.45 before.
  const auto limits = LimitClips({700, 100, 100, 100}, 1, 1, 1);

  EXPECT_NEAR(limits[0].floor_share, 0.7 / 1.45, 1e-12);
  EXPECT_NEAR(limits[1].floor_share, 0.25 / 1.45, 1e-12);
}

TEST(LimitClips, LiftsACapThatTheClipsCouldNotFill) {
  EXPECT_DOUBLE_EQ(LimitClips({10}, 0.1, 0.1, 0.25)[0].cap, 1);
  EXPECT_DOUBLE_EQ(LimitClips({10, 10}, 0.1, 0.1, 0.25)[0].cap, 1);
  EXPECT_DOUBLE_EQ(LimitClips({10, 10, 10, 10}, 0, 0, 0.1)[0].cap, 0.5);
  // A clip's own floor lies above it: 0.9 of the frames.
  EXPECT_DOUBLE_EQ(LimitClips({90, 4, 3, 3}, 0.8, 0, 0.1)[0].cap, 0.8 * 0.9);
}

TEST(LimitClips, PassesOverClipsWithoutBins) {
  const auto limits = LimitClips({0, 30, 10}, 0.4, 0, 0.25);

  EXPECT_EQ(limits[0].floor_share, 0);
  EXPECT_EQ(limits[0].cap, 0);
  EXPECT_DOUBLE_EQ(limits[1].floor_share, 0.3);
  EXPECT_DOUBLE_EQ(limits[1].cap, 1);  // 2 / 2
}

TEST(ShareAboveFloors, FollowsWeightsWhereNoCapIsReached) {
  const std::vector<ClipLimits> limits = {{0.1, 1}, {0.1, 1}};

  EXPECT_THAT(ShareAboveFloors(limits, {3, 1}),
              ElementsAre(DoubleEq(0.6), DoubleEq(0.2)));
}

TEST(ShareAboveFloors, GivesWhatIsAboveACapToTheOthers) {
  // 0.9, 0.09 and 0.01 by weight: the first is cut to 0.5, then the second,
  // 0.45, to 0.4.
  const std::vector<ClipLimits> limits = {{0, 0.5}, {0, 0.4}, {0, 0.4}};

  const auto extras = ShareAboveFloors(limits, {90, 9, 1});

  EXPECT_DOUBLE_EQ(extras[0], 0.5);
  EXPECT_DOUBLE_EQ(extras[1], 0.4);
  EXPECT_NEAR(extras[2], 0.1, 1e-12);
}

TEST(ShareAboveFloors, FillsAllClipsWhereTheirCapsSumToOne) {
  const std::vector<ClipLimits> limits(4, ClipLimits{0.05, 0.25});

  for (const double extra : ShareAboveFloors(limits, {1000, 1, 1, 1})) {
    EXPECT_NEAR(extra, 0.2, 1e-12);
  }
}

double Room(const ClipLimits& limits) {
  return limits.cap - limits.floor_share;
}

// Proportional to the weights up to the caps.
TEST(ShareAboveFloors, HoldsItsLawForAnyWeights) {
  for (uint64_t trial = 0; trial < 300; ++trial) {
    const RandomKey key{.seed = 11, .environment = trial};
    const auto count = static_cast<size_t>(1 + UniformInt(key, 40, 0));
    std::vector<double> frames(count), weights(count);
    for (size_t c = 0; c < count; ++c) {
      const bool has_bins = c == 0 || Uniform(key, 4 * c + 1) < 0.8;
      frames[c] = has_bins ? 1 + Uniform(key, 4 * c + 2) * 1000 : 0;
      const double u = Uniform(key, 4 * c + 3);
      weights[c] = frames[c] * (u * u * u * u + 1e-6);
    }
    const auto limits =
        LimitClips(frames, Uniform(key, 1001), Uniform(key, 1002),
                   0.01 + 0.9 * Uniform(key, 1003));

    const std::vector<double> extras = ShareAboveFloors(limits, weights);

    double sum = 0;
    std::optional<double> per_weight;  // of all that no cap stops
    for (size_t c = 0; c < count; ++c) {
      sum += limits[c].floor_share + extras[c];
      EXPECT_GE(extras[c], 0);
      EXPECT_LE(limits[c].floor_share + extras[c], limits[c].cap + 1e-12);
      if (weights[c] > 0 && extras[c] < Room(limits[c]) - 1e-12) {
        const double own = extras[c] / weights[c];
        EXPECT_NEAR(own, per_weight.value_or(own), 1e-9 * own) << trial;
        per_weight = own;
      }
    }
    EXPECT_NEAR(sum, 1, 1e-12) << "trial " << trial;
    if (!per_weight) continue;
    for (size_t c = 0; c < count; ++c) {
      if (extras[c] < Room(limits[c]) - 1e-12) continue;
      EXPECT_LE(Room(limits[c]), *per_weight * weights[c] + 1e-12) << trial;
    }
  }
}

}  // namespace
}  // namespace sinew::learner
