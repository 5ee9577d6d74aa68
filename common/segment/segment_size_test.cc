#include "common/segment/segment_size.h"

#include <cstdint>
#include <limits>
#include <string>

#include "gtest/gtest.h"
#include "proto/sinew/v1/rollout.pb.h"

namespace sinew {
namespace {

constexpr int64_t kMost = int64_t{1} << 62;

void AddColumn(v1::SegmentLayout::Lead lead, int64_t width,
               v1::SegmentLayout& layout) {
  v1::SegmentLayout::Column& column = *layout.add_columns();
  column.set_dtype(v1::DATA_TYPE_FLOAT32);
  column.add_shape(width);
  column.set_lead(lead);
}

// A column of every lead, wide enough to be most of a segment.
v1::SegmentLayout WideLayout() {
  v1::SegmentLayout layout;
  AddColumn(v1::SegmentLayout::LEAD_STEP, 1000, layout);
  AddColumn(v1::SegmentLayout::LEAD_BOUNDARY, 3000, layout);
  AddColumn(v1::SegmentLayout::LEAD_TRUNCATION, 5000, layout);
  return layout;
}

TEST(MaxTrainingBytes, GrowsByARowOfEveryColumnAndAnEpisode) {
  const v1::SegmentLayout layout = WideLayout();

  // A step of two environments: both 1000 + 5000 numbers, 64 bytes.
  EXPECT_EQ(MaxTrainingBytes(layout, 2, 11) - MaxTrainingBytes(layout, 2, 10),
            2 * (4 * 6000 + 64));
  // An environment of ten steps: them, 3000 numbers once, 16 KiB.
  EXPECT_EQ(MaxTrainingBytes(layout, 3, 10) - MaxTrainingBytes(layout, 2, 10),
            10 * (4 * 6000 + 64) + 4 * 3000 + (16 << 10));
}

TEST(MaxTrainingBytes, BoundsASegmentWhoseStepsAreAllTruncated) {
  v1::Segment segment;
  for (int64_t bytes : {10 * 1000 * 4, 3000 * 4, 10 * 5000 * 4}) {
    segment.add_columns()->set_data(std::string(bytes, '\1'));
  }
  for (int i = 0; i < 10; ++i) {
    v1::EpisodeEnd& episode = *segment.add_episodes();
    episode.set_environment(1 << 20);
    episode.set_clip(1 << 20);
    episode.set_start_frame(1 << 20);
    episode.set_steps(1 << 20);
    episode.set_episode(int64_t{1} << 40);
    episode.set_episode_return(0.1);
    episode.set_mean_body_distance(0.1);
  }
  const int64_t size = static_cast<int64_t>(segment.ByteSizeLong());
  const int64_t most = MaxTrainingBytes(WideLayout(), 1, 10);

  EXPECT_GE(most, size);
  EXPECT_LE(most, size + (64 << 10) + (16 << 10) + 10 * 64);
}

TEST(MaxEvaluationBytes, BoundsTheResultsOfManyBodies) {
  v1::Segment segment;
  for (int i = 0; i < 32; ++i) {
    v1::EvaluationResult& result = *segment.add_results();
    for (int body = 0; body < 60; ++body) result.add_sum_body_mm(1e4);
    for (int move = 0; move < 100; ++move) {
      auto& carried = *result.add_carried();
      carried.set_after_frames(1 << 16);
      carried.set_clip(1 << 16);
      carried.set_start_frame(1 << 16);
    }
  }

  EXPECT_GE(MaxEvaluationBytes(32),
            static_cast<int64_t>(segment.ByteSizeLong()));
  EXPECT_EQ(MaxEvaluationBytes(33) - MaxEvaluationBytes(32), 4 << 10);
}

TEST(MaxSegmentBytes, SaysTheMostWhereNumbersEnd) {
  v1::SegmentLayout layout;
  for (int i = 0; i < 9; ++i) {
    AddColumn(v1::SegmentLayout::LEAD_STEP, int64_t{1} << 20, layout);
  }
  layout.mutable_columns(0)->add_shape(int64_t{1} << 20);

  EXPECT_EQ(MaxTrainingBytes(layout, 1 << 20, 1 << 20), kMost);
  EXPECT_EQ(MaxEvaluationBytes(std::numeric_limits<int64_t>::max()), kMost);
}

}  // namespace
}  // namespace sinew
