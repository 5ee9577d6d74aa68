#include "common/evaluation/evaluation_summary.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace sinew {
namespace {

using ::testing::ElementsAre;

v1::EvaluationResult Result(int clip, int start, int steps, int failed_at,
                            double g_mpjpe_per_frame) {
  v1::EvaluationResult result;
  result.set_clip(clip);
  result.set_start_frame(start);
  result.set_steps(steps);
  result.set_success(failed_at < 0);
  result.set_failed_at_frame(failed_at);
  const int frames = failed_at < 0 ? steps : failed_at;
  result.set_frames(frames);
  result.set_velocity_frames(frames - 1);
  result.set_acceleration_frames(frames - 2);
  result.set_sum_g_mpjpe_mm(frames * g_mpjpe_per_frame);
  result.set_sum_mpjpe_mm(frames * 5.0);
  result.set_sum_velocity((frames - 1) * 3.0);
  result.set_sum_acceleration((frames - 2) * 2.0);
  result.add_sum_body_mm(frames * 1.0);
  result.add_sum_body_mm(frames * 7.0);
  return result;
}

TEST(EvaluationSummary, OfNothingIsZero) {
  const EvaluationSummary summary = SummariseEvaluation({});

  EXPECT_EQ(summary.overall.clips, 0);
  EXPECT_EQ(summary.overall.means.e_g_mpjpe_mm, 0);
  EXPECT_TRUE(summary.clips.empty());
}

TEST(EvaluationSummary, AClipSucceedsIfAllItsStartsDo) {
  const std::vector<v1::EvaluationResult> results = {
      Result(0, 0, 100, -1, 10), Result(0, 20, 100, -1, 30),
      Result(1, 0, 100, 40, 50), Result(1, 20, 100, -1, 20),
      Result(1, 30, 100, 25, 20)};

  const EvaluationSummary summary = SummariseEvaluation(results);

  ASSERT_EQ(summary.clips.size(), 2u);
  EXPECT_TRUE(summary.clips[0].success);
  EXPECT_EQ(summary.clips[0].failed_at_frame, -1);
  EXPECT_FALSE(summary.clips[1].success);
  EXPECT_EQ(summary.clips[1].succeeded_starts, 1);
  EXPECT_EQ(summary.clips[1].failed_at_frame, 25);
  EXPECT_DOUBLE_EQ(summary.overall.success_rate, 0.5);
  EXPECT_EQ(summary.successful.clips, 1);
  EXPECT_DOUBLE_EQ(summary.successful.success_rate, 1);
}

TEST(EvaluationSummary, KnowsWhichClipsSucceedFromTheirEarliestStart) {
  const std::vector<v1::EvaluationResult> results = {
      Result(0, 20, 80, 40, 10), Result(0, 0, 100, -1, 10),
      Result(1, 5, 100, 40, 50), Result(1, 20, 100, -1, 20)};

  const EvaluationSummary summary = SummariseEvaluation(results, {false, true});

  EXPECT_TRUE(summary.clips[0].first_start_success);
  EXPECT_FALSE(summary.clips[1].first_start_success);
  EXPECT_EQ(summary.overall.first_start_successes, 1);
  EXPECT_EQ(summary.training.first_start_successes, 1);
  EXPECT_EQ(summary.left_out.first_start_successes, 0);
}

TEST(EvaluationSummary, SumsUpTrainingAndLeftOutClipsApart) {
  const std::vector<v1::EvaluationResult> results = {Result(0, 0, 100, -1, 10),
                                                     Result(1, 0, 100, 50, 40),
                                                     Result(2, 0, 100, -1, 30)};

  const EvaluationSummary summary =
      SummariseEvaluation(results, {false, true, true});

  EXPECT_EQ(summary.overall.clips, 3);
  EXPECT_EQ(summary.training.clips, 1);
  EXPECT_DOUBLE_EQ(summary.training.means.e_g_mpjpe_mm, 10);
  EXPECT_EQ(summary.left_out.clips, 2);
  EXPECT_DOUBLE_EQ(summary.left_out.success_rate, 0.5);
  EXPECT_DOUBLE_EQ(summary.left_out.survived_share, 0.75);
  EXPECT_EQ(summary.training_successful.clips, 1);
  EXPECT_EQ(summary.left_out_successful.clips, 1);
  EXPECT_DOUBLE_EQ(summary.left_out_successful.means.e_g_mpjpe_mm, 30);
  EXPECT_FALSE(summary.clips[0].left_out);
  EXPECT_TRUE(summary.clips[2].left_out);
}

TEST(EvaluationSummary, CallsAllClipsTrainingWhereNoneIsLeftOut) {
  v1::MotionLibrary library;
  library.add_clips();
  library.add_clips()->set_left_out(true);
  EXPECT_THAT(LeftOutClips(library), ElementsAre(false, true));

  const EvaluationSummary summary =
      SummariseEvaluation(std::vector{Result(0, 0, 100, 50, 40)});

  EXPECT_EQ(summary.training.clips, 1);
  EXPECT_EQ(summary.training.frames, summary.overall.frames);
  EXPECT_EQ(summary.left_out.clips, 0);
}

TEST(EvaluationSummary, PoolsFramesOfAllMotions) {
  const std::vector<v1::EvaluationResult> results = {Result(0, 0, 100, -1, 10),
                                                     Result(1, 0, 100, 50, 40)};

  const EvaluationSummary summary = SummariseEvaluation(results);

  // (100 * 10 + 50 * 40) / 150 = 20 mm; 150 of 200 frames reached.
  EXPECT_DOUBLE_EQ(summary.overall.means.e_g_mpjpe_mm, 20);
  EXPECT_DOUBLE_EQ(summary.overall.survived_share, 0.75);
  EXPECT_DOUBLE_EQ(summary.overall.means.e_mpjpe_mm, 5);
  EXPECT_DOUBLE_EQ(summary.overall.means.e_vel, 3);
  EXPECT_DOUBLE_EQ(summary.overall.means.e_acc, 2);
  EXPECT_THAT(summary.overall.body_mm, ElementsAre(1, 7));
  EXPECT_DOUBLE_EQ(summary.successful.means.e_g_mpjpe_mm, 10);
}

TEST(EvaluationSummary, IsTheSameInAnyOrder) {
  std::vector<v1::EvaluationResult> results;
  for (int i = 0; i < 12; ++i) {
    results.push_back(Result(i % 3, i, 100, -1, 1.0 / (i + 1)));
    // Fallen ones differ in their body alone.
    results.push_back(Result(i % 3, 0, 100, i % 2 - 1, 1.0 / (i + 20)));
    results.back().set_fallen_state(i);
  }
  const SetSummary expected = SummariseEvaluation(results).overall;

  std::reverse(results.begin(), results.end());

  const SetSummary found = SummariseEvaluation(results).overall;
  EXPECT_EQ(found.means.e_g_mpjpe_mm, expected.means.e_g_mpjpe_mm);
  EXPECT_EQ(found.first_start_successes, expected.first_start_successes);
}

}  // namespace
}  // namespace sinew
