#include "learner/curriculum/curriculum_summary.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace sinew::learner {
namespace {

using ::testing::ElementsAre;

// Clips of 2 bins, 1 bin, and one that is left out. Bins of 10 frames each with
// probabilities 0.5, 0.25, 0.25 and failure rates 0.9, 0.1, 0.5.
v1::CurriculumTable MakeTable() {
  v1::CurriculumTable table;
  table.set_bin_frames(10);
  const double probability[] = {0.5, 0.25, 0.25};
  const double failures[] = {8, 0, 4};
  for (int b = 0; b < 3; ++b) {
    auto& bin = *table.add_bins();
    bin.set_clip(b / 2);
    bin.set_first_frame(10 * (b % 2));
    bin.set_num_frames(10);
    bin.set_probability(probability[b]);
    bin.set_recent_passages(8);  // (failures + 1) / 10
    bin.set_recent_failures(failures[b]);
    bin.set_visits(b + 1);
    bin.set_failures(b);
    bin.set_last_seen(10 * b - 1);
  }
  for (int c = 0; c < 3; ++c) table.add_clips()->set_last_evaluated(-1);
  table.mutable_clips(2)->set_left_out(true);
  return table;
}

void Evaluate(v1::CurriculumTable& table, int clip, double succeeded_share) {
  auto& evaluated = *table.mutable_clips(clip);
  evaluated.set_evaluations(1);
  evaluated.set_failed_latest(succeeded_share < 1);
  evaluated.set_succeeded_share(succeeded_share);
}

TEST(CurriculumSummary, SaysHowFocusedTheStartsAre) {
  const CurriculumSummary summary =
      Summarise(MakeTable(), *MakeFailureRateRule(0.3));

  EXPECT_EQ(summary.clips, 2);
  EXPECT_EQ(summary.left_out_clips, 1);
  EXPECT_EQ(summary.bins, 3);
  // 0.5 ln 2 + 2 * 0.25 ln 4 = 1.5 ln 2, of ln 3.
  EXPECT_NEAR(summary.entropy, 1.5 * std::log(2), 1e-12);
  EXPECT_NEAR(summary.entropy_share, 1.5 * std::log(2) / std::log(3), 1e-12);
  EXPECT_EQ(summary.floor_share, 0.3);
  EXPECT_EQ(summary.largest_clip_share, 0.75);
  EXPECT_EQ(summary.clips_of_half, 1);
}

TEST(CurriculumSummary, SaysWhatTheHardestBinsAreLike) {
  const CurriculumSummary summary = Summarise(MakeTable(), *MakeUniformRule());

  EXPECT_NEAR(summary.failure_rate, 0.5, 1e-12);
  // One bin of three.
  EXPECT_EQ(summary.hardest_share, 0.5);
  EXPECT_NEAR(summary.hardest_failure_rate, 0.9, 1e-12);
}

TEST(CurriculumSummary, SaysWhatEvaluationsFoundOfClipsThatAreTrainedOn) {
  v1::CurriculumTable table = MakeTable();
  const CurriculumSummary before = Summarise(table, *MakeUniformRule());
  EXPECT_EQ(before.evaluated_clips, 0);
  EXPECT_EQ(before.worst_success, 0);
  Evaluate(table, 0, 0.25);
  Evaluate(table, 1, 1);
  Evaluate(table, 2, 0);  // left out

  const CurriculumSummary summary = Summarise(table, *MakeUniformRule());

  EXPECT_EQ(summary.evaluated_clips, 2);
  EXPECT_EQ(summary.hard_clips, 1);
  EXPECT_EQ(summary.worst_success, 0.25);
}

TEST(CurriculumSummary, OfOneBinIsAsWideAsItCanBe) {
  v1::CurriculumTable table;
  table.add_bins()->set_num_frames(10);
  table.mutable_bins(0)->set_probability(1);

  const CurriculumSummary summary = Summarise(table, *MakeUniformRule());

  EXPECT_EQ(summary.entropy, 0);
  EXPECT_EQ(summary.entropy_share, 1);
  EXPECT_EQ(summary.clips, 1);
}

TEST(CurriculumSummary, OfAnEmptyTableIsEmpty) {
  EXPECT_EQ(Summarise(v1::CurriculumTable(), *MakeUniformRule()).clips, 0);
}

TEST(StatisticsByClip, AddUpOverBins) {
  const auto clips = StatisticsByClip(MakeTable());

  ASSERT_EQ(clips.size(), 3u);
  EXPECT_EQ(clips[0].bins, 2);
  EXPECT_EQ(clips[0].visits, 3);
  EXPECT_EQ(clips[0].failures, 1);
  EXPECT_NEAR(clips[0].failure_rate, 0.5, 1e-12);
  EXPECT_EQ(clips[0].probability, 0.75);
  EXPECT_EQ(clips[0].last_seen, 9);
  EXPECT_EQ(clips[2].bins, 0);
  EXPECT_EQ(clips[2].last_seen, -1);
}

TEST(HardestBins, ComeFirstByFailureRate) {
  EXPECT_THAT(HardestBins(MakeTable(), 2), ElementsAre(0, 2));
  EXPECT_THAT(HardestBins(MakeTable(), 9), ElementsAre(0, 2, 1));
  EXPECT_THAT(HardestBins(MakeTable(), 0), ElementsAre());
}

TEST(HardestClips, ComeFirstByEvaluationThenByFailureRate) {
  v1::CurriculumTable table = MakeTable();
  // Rates are 0.5 both.
  EXPECT_THAT(HardestClips(table, 9), ElementsAre(0, 1));
  table.mutable_bins(2)->set_recent_failures(5);
  EXPECT_THAT(HardestClips(table, 9), ElementsAre(1, 0));
  Evaluate(table, 0, 0.5);
  Evaluate(table, 1, 1);
  Evaluate(table, 2, 0);
  EXPECT_THAT(HardestClips(table, 9), ElementsAre(0, 1));
  EXPECT_THAT(HardestClips(table, 1), ElementsAre(0));
}

}  // namespace
}  // namespace sinew::learner
