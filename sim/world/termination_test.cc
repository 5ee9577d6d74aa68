#include "sim/world/termination.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace sinew::world {
namespace {

constexpr int64_t kForEver = int64_t{1} << 60;

TEST(MeasureDistances, TakesTheMeanOverAllAndTheLargestOfTheTerminating) {
  BodyState body(3, 0), reference(3, 0);
  body.position[0] = {0.3, 0, 0.4};  // 0.5
  body.position[1] = {0, 0.1, 0};
  body.position[2] = {0.9, 0, 0};  // exempt
  const std::vector<int> terminating = {0, 1};

  const BodyDistances distances =
      MeasureDistances(body, reference, terminating);

  EXPECT_DOUBLE_EQ(distances.mean, 0.5);
  EXPECT_DOUBLE_EQ(distances.max_terminating, 0.5);
}

TEST(JudgeEpisode, TerminatesBeyondTheDistanceFromTheSecondStepOn) {
  EXPECT_FALSE(JudgeEpisode(0.26, 0.25, 0, 1, kForEver, 300).terminated);
  EXPECT_TRUE(JudgeEpisode(0.26, 0.25, 0, 2, kForEver, 300).terminated);
  EXPECT_FALSE(JudgeEpisode(0.25, 0.25, 0, 2, kForEver, 300).terminated);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(JudgeEpisode(nan, 0.25, 0, 2, kForEver, 300).terminated);
}

TEST(JudgeEpisode, TruncatesAtTheTimeLimit) {
  EXPECT_FALSE(JudgeEpisode(0, 0.25, 7, 299, kForEver, 300).time_limit);
  EXPECT_TRUE(JudgeEpisode(0, 0.25, 7, 300, kForEver, 300).time_limit);
}

TEST(JudgeEpisode, TruncatesAtTheLastFrameOfAClip) {
  EXPECT_FALSE(JudgeEpisode(0, 0.25, 10, 8, 19, 300).clip_end);
  EXPECT_TRUE(JudgeEpisode(0, 0.25, 10, 9, 19, 300).clip_end);
}

TEST(JudgeEpisode, NamesOneReasonOnly) {
  const EpisodeEnding failed = JudgeEpisode(1, 0.25, 10, 9, 19, 9);
  EXPECT_TRUE(failed.terminated);
  EXPECT_FALSE(failed.clip_end || failed.time_limit);

  const EpisodeEnding ended = JudgeEpisode(0, 0.25, 10, 9, 19, 9);
  EXPECT_TRUE(ended.clip_end);
  EXPECT_FALSE(ended.time_limit);
}

}  // namespace
}  // namespace sinew::world
