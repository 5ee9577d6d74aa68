#include "common/evaluation/evaluation_starts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/testing/matchers.h"

namespace sinew {
namespace {

using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

v1::MotionLibrary Library() {
  v1::MotionLibrary library;
  library.set_frames_per_second(30);
  v1::ClipInfo* loop = library.add_clips();
  loop->set_num_frames(40);
  loop->set_loops(true);
  library.add_clips()->set_num_frames(41);
  return library;
}

TEST(EvaluationStarts, SpreadOverTheWholePhaseOfALoop) {
  const auto starts = MakeEvaluationStarts(Library(), 4, 10);

  ASSERT_TRUE(starts.ok());
  ASSERT_EQ(starts->size(), 8u);
  for (int k = 0; k < 4; ++k) {
    EXPECT_EQ((*starts)[k].clip(), 0);
    EXPECT_EQ((*starts)[k].start_frame(), 10 * k);
    EXPECT_EQ((*starts)[k].steps(), 300);
  }
}

TEST(EvaluationStarts, RunOtherClipsToTheirEndFromTheFirstHalf) {
  const auto starts = MakeEvaluationStarts(Library(), 4, 10);

  ASSERT_TRUE(starts.ok());
  for (int k = 0; k < 4; ++k) {
    EXPECT_EQ((*starts)[4 + k].clip(), 1);
    EXPECT_EQ((*starts)[4 + k].start_frame(), 5 * k);
    EXPECT_EQ((*starts)[4 + k].steps(), 40 - 5 * k);
  }
}

TEST(EvaluationStarts, AreTheFirstFramesWhereThereIsOneOfEachClip) {
  const auto starts = MakeEvaluationStarts(Library(), 1, 10);

  ASSERT_TRUE(starts.ok());
  ASSERT_EQ(starts->size(), 2u);
  EXPECT_EQ((*starts)[0].start_frame(), 0);
  EXPECT_EQ((*starts)[0].steps(), 300);
  EXPECT_EQ((*starts)[1].start_frame(), 0);
  EXPECT_EQ((*starts)[1].steps(), 40);
}

TEST(EvaluationStarts, RefuseNoStartsAndNoTime) {
  EXPECT_THAT(MakeEvaluationStarts(Library(), 0, 10),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("starts: expected >= 1, found 0")));
  EXPECT_THAT(MakeEvaluationStarts(Library(), 1, 0.01),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("seconds: expected at least one frame")));
}

}  // namespace
}  // namespace sinew
