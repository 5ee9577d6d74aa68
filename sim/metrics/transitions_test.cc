#include "sim/metrics/transitions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "common/testing/matchers.h"

namespace sinew::metrics {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::DoubleNear;
using ::testing::ElementsAre;

// Numbers that repeat after a long while, in [-1, 1).
FeatureRows Scattered(int rows, int columns, uint32_t seed) {
  FeatureRows result(rows, columns);
  for (int i = 0; i < rows * columns; ++i) {
    seed = 1664525 * seed + 1013904223;
    result.data()[i] = static_cast<float>(seed >> 8) / (1 << 23) - 1;
  }
  return result;
}

TransitionMatch Match(const FeatureRows& library, const FeatureRows& generated,
                      int threads = 1) {
  auto match = MatchTransitions(library, generated, threads, StopToken());
  EXPECT_THAT(match, IsOk());
  return *std::move(match);
}

TEST(TransitionSet, HoldsPairsOfConsecutiveStatesOfEachMotion) {
  TransitionSet set(/*features=*/2, /*announced=*/3, /*most=*/10);

  set.AddMotion({1, 2, 3, 4, 5, 6});
  set.AddMotion({7, 8, 9, 10});

  ASSERT_EQ(set.size(), 3);
  FeatureRows expected(3, 4);
  expected << 1, 2, 3, 4,  //
      3, 4, 5, 6,          //
      7, 8, 9, 10;
  EXPECT_EQ(FeatureRows(set.rows()), expected);
}

TEST(TransitionSet, KeepsAsManyAsItMayEvenlySpaced) {
  TransitionSet set(/*features=*/1, /*announced=*/6, /*most=*/3);

  // Of transitions 0 .. 5, those where floor(k 3 / 6) changes: 1, 3, 5.
  set.AddMotion({0, 1, 2, 3, 4, 5, 6});

  EXPECT_EQ(set.seen(), 6);
  ASSERT_EQ(set.size(), 3);
  EXPECT_EQ(set.rows()(0, 0), 1);
  EXPECT_EQ(set.rows()(1, 0), 3);
  EXPECT_EQ(set.rows()(2, 0), 5);
}

TEST(TransitionSet, HasNoneOfAMotionOfOneState) {
  TransitionSet set(/*features=*/2, /*announced=*/5, /*most=*/5);

  set.AddMotion({1, 2});

  EXPECT_EQ(set.size(), 0);
}

TEST(Standardise, MakesTheLibraryMeanZeroAndDeviationOne) {
  TransitionSet set(/*features=*/2, /*announced=*/1, /*most=*/1);
  // Feature 0: -1 and 3, mean 1, deviation 2. Feature 1 never varies: its
  // deviation counts as 0.1.
  set.AddMotion({-1, 5, 3, 5});

  const Standardisation standardisation = Standardise(set);

  EXPECT_FLOAT_EQ(standardisation.mean[0], 1);
  EXPECT_FLOAT_EQ(standardisation.inverse_deviation[0], 0.5);
  EXPECT_FLOAT_EQ(standardisation.mean[1], 5);
  EXPECT_FLOAT_EQ(standardisation.inverse_deviation[1], 10);
  FeatureRows expected(1, 4);
  expected << -1, 0, 1, 0;
  EXPECT_TRUE(Standardised(set, standardisation).isApprox(expected));
}

TEST(MatchTransitions, FindsTheNearestBothWays) {
  FeatureRows library(3, 2), generated(2, 2);
  library << 0, 0, 10, 0, 0, 20;
  generated << 1, 1, 10, 2;

  const TransitionMatch match = Match(library, generated);

  EXPECT_THAT(match.generated_nearest, ElementsAre(0, 1));
  // sqrt((1 + 1) / 2) = 1, sqrt(4 / 2); from (0, 20) the nearer is (1, 1):
  // sqrt((1 + 361) / 2).
  EXPECT_THAT(match.generated_distance,
              ElementsAre(DoubleNear(1, 1e-6), DoubleNear(std::sqrt(2), 1e-6)));
  EXPECT_THAT(match.library_distance,
              ElementsAre(DoubleNear(1, 1e-6), DoubleNear(std::sqrt(2), 1e-6),
                          DoubleNear(std::sqrt(181), 1e-5)));
}

TEST(MatchTransitions, SaysZeroOfWhatIsAlike) {
  const FeatureRows rows = Scattered(7, 6, 1);

  const TransitionMatch match = Match(rows, rows);

  for (int i = 0; i < 7; ++i) {
    EXPECT_EQ(match.generated_nearest[i], i);
    EXPECT_EQ(match.generated_distance[i], 0);
    EXPECT_EQ(match.library_distance[i], 0);
  }
}

TEST(MatchTransitions, AgreesWithComparingAllPairsAcrossBlocks) {
  // More than a block of each: 1024 and 256 rows.
  const FeatureRows library = Scattered(1100, 8, 2);
  const FeatureRows generated = Scattered(300, 8, 3);

  const TransitionMatch match = Match(library, generated);

  for (int g = 0; g < 300; ++g) {
    const double nearest =
        (library.rowwise() - generated.row(g)).rowwise().norm().minCoeff() /
        std::sqrt(8.0);
    ASSERT_NEAR(match.generated_distance[g], nearest, 1e-5) << g;
  }
  for (int l = 0; l < 1100; ++l) {
    const double nearest =
        (generated.rowwise() - library.row(l)).rowwise().norm().minCoeff() /
        std::sqrt(8.0);
    ASSERT_NEAR(match.library_distance[l], nearest, 1e-5) << l;
  }
}

TEST(MatchTransitions, GivesTheSameBitsForAnyNumberOfThreads) {
  const FeatureRows library = Scattered(1500, 4, 4);
  const FeatureRows generated = Scattered(1000, 4, 5);

  const TransitionMatch one = Match(library, generated, /*threads=*/1);
  const TransitionMatch three = Match(library, generated, /*threads=*/3);

  EXPECT_EQ(one.generated_nearest, three.generated_nearest);
  EXPECT_EQ(one.generated_distance, three.generated_distance);
  EXPECT_EQ(one.library_distance, three.library_distance);
}

TEST(MatchTransitions, StopsWhenItIsAskedTo) {
  StopSource source;
  source.request_stop();

  EXPECT_THAT(MatchTransitions(Scattered(2, 2, 1), Scattered(2, 2, 2), 1,
                               source.get_token())
                  .status(),
              StatusIs(absl::StatusCode::kCancelled));
}

TEST(SummariseMatch, CountsCoverageByThresholdAndByNearest) {
  const TransitionMatch match = {.generated_distance = {0.5, 1.0, 0.3},
                                 .generated_nearest = {2, 0, 2},
                                 .library_distance = {1.0, 0.7, 0.3, 0.5}};

  const TransitionFigures figures =
      SummariseMatch(match, /*features=*/3, /*threshold=*/0.5);

  EXPECT_EQ(figures.library, 4);
  EXPECT_EQ(figures.generated, 3);
  EXPECT_DOUBLE_EQ(figures.distance, 0.6);
  // 2 F times the mean of 0.25, 1 and 0.09: 6 * 1.34 / 3.
  EXPECT_DOUBLE_EQ(figures.squared, 2.68);
  // Of 0.25 and 0.09 alone: 6 * 0.34 / 2.
  EXPECT_DOUBLE_EQ(figures.squared_within, 1.02);
  EXPECT_DOUBLE_EQ(figures.far_share, 1.0 / 3);
  EXPECT_DOUBLE_EQ(figures.coverage, 0.5);  // 0.3 and 0.5
  EXPECT_DOUBLE_EQ(figures.matched, 0.5);   // 0 and 2
}

TEST(SummariseMatch, HasNoMeanOverNoTransitions) {
  const TransitionMatch match = {.generated_distance = {0.6},
                                 .generated_nearest = {0},
                                 .library_distance = {0.6}};

  const TransitionFigures figures =
      SummariseMatch(match, /*features=*/3, /*threshold=*/0.5);

  EXPECT_DOUBLE_EQ(figures.far_share, 1);
  EXPECT_TRUE(std::isnan(figures.squared_within));
}

TEST(SharedCoverage, IsOfWhatTheOtherCovers) {
  const TransitionMatch match = {.generated_distance = {},
                                 .generated_nearest = {},
                                 .library_distance = {0.1, 0.9, 0.1, 0.1}};
  const TransitionMatch other = {.generated_distance = {},
                                 .generated_nearest = {},
                                 .library_distance = {0.2, 0.2, 0.2, 0.9}};

  EXPECT_DOUBLE_EQ(SharedCoverage(match, other, 0.5), 2.0 / 3);
  EXPECT_TRUE(std::isnan(SharedCoverage(match, other, 0.05)));
}

}  // namespace
}  // namespace sinew::metrics
