// Evaluation orders.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "actor/rollout.h"
#include "actor/testing/rollout_rig.h"
#include "common/digest.h"
#include "common/testing/matchers.h"

namespace sinew::actor {
namespace {

using ::sinew::testing::StatusIs;
using testing::Bytes;
using testing::RolloutRig;

TEST(Evaluation, SurvivesWhatCanBeDoneAndFailsWhatCannot) {
  RolloutRig rig;
  rig.UseZeroAction();

  const v1::Segment segment =
      rig.Run(rig.EvaluationOrder({{1, 0, 19}, {2, 0, 15}, {1, 5, 14}}));

  ASSERT_EQ(segment.results_size(), 3);
  EXPECT_EQ(segment.columns_size(), 0);
  const v1::EvaluationResult& standing = segment.results(0);
  EXPECT_TRUE(standing.success());
  EXPECT_EQ(standing.frames(), 19);
  EXPECT_EQ(standing.failed_at_frame(), -1);
  EXPECT_EQ(standing.velocity_frames(), 18);
  EXPECT_EQ(standing.acceleration_frames(), 17);
  EXPECT_LT(standing.sum_g_mpjpe_mm() / 19, 50);
  EXPECT_EQ(standing.sum_body_mm_size(), 5);
  const v1::EvaluationResult& tumble = segment.results(1);
  EXPECT_FALSE(tumble.success());
  EXPECT_EQ(tumble.frames(), tumble.failed_at_frame());
  EXPECT_LT(tumble.frames(), 15);
  EXPECT_GT(tumble.sum_g_mpjpe_mm(), 500);
  EXPECT_EQ(segment.results(2).start_frame(), 5);
}

TEST(Evaluation, BodySumsAddUpToTheMean) {
  RolloutRig rig;
  const v1::Segment segment = rig.Run(rig.EvaluationOrder({{0, 3, 30}}));

  double sum = 0;
  for (double body : segment.results(0).sum_body_mm()) sum += body;
  EXPECT_NEAR(sum / 5, segment.results(0).sum_g_mpjpe_mm(), 1e-9);
}

TEST(Evaluation, StartsAreIndependentOfEachOther) {
  RolloutRig rig;
  const std::vector<testing::Start> starts = {
      {0, 3, 30}, {2, 0, 15}, {0, 9, 8}};
  const v1::Segment together = rig.Run(rig.EvaluationOrder(starts));

  for (size_t i = 0; i < starts.size(); ++i) {
    const v1::Segment alone = rig.Run(rig.EvaluationOrder({starts[i]}));
    EXPECT_EQ(SerializeDeterministically(alone.results(0)),
              SerializeDeterministically(together.results(i)));
  }
}

TEST(Evaluation, DoesNotDependOnTheSeed) {
  RolloutRig rig;
  v1::Order order = rig.EvaluationOrder({{0, 3, 30}});
  const std::string first = Bytes(rig.Run(order));
  order.set_seed(order.seed() + 1);

  EXPECT_EQ(Bytes(rig.Run(order)), first);
}

TEST(Evaluation, ShowsEveryFrameToItsObserver) {
  RolloutRig rig;
  rig.UseZeroAction();
  std::vector<int> frames;
  rig.worker->SetFrameObserver([&](int start, int frame, const mjData& data,
                                   absl::Span<const float> latent) {
    EXPECT_EQ(start, 0);
    EXPECT_GT(data.xpos[5], 0.3);  // the trunk's height
    EXPECT_THAT(latent, ::testing::IsEmpty());
    frames.push_back(frame);
  });

  rig.Run(rig.EvaluationOrder({{1, 0, 4}}));

  EXPECT_THAT(frames, ::testing::ElementsAre(1, 2, 3, 4));
}

TEST(Evaluation, AnErrorOfTheEngineInAStepIsADivergence) {
  RolloutRig rig;
  rig.UseZeroAction();
  rig.worker->SetFrameObserver(
      [](int start, int frame, const mjData&, absl::Span<const float>) {
        if (start == 1 && frame == 2) mju_error("no room");
      });

  const v1::Segment segment =
      rig.Run(rig.EvaluationOrder({{1, 0, 4}, {1, 0, 4}}));

  EXPECT_TRUE(segment.results(0).success());
  EXPECT_EQ(segment.results(1).failed_at_frame(), 2);
  EXPECT_EQ(segment.diverged(), 1);
}

TEST(Evaluation, AnErrorOfTheEngineElsewhereEndsTheOrderAndNotTheWorker) {
  RolloutRig rig;
  rig.UseZeroAction();
  rig.worker->SetFrameObserver(
      [](int, int, const mjData& shown, absl::Span<const float>) {
        mjData& data = const_cast<mjData&>(shown);
        const size_t room = data.narena - data.parena - data.pstack;
        mj_stackAllocByte(&data, room - 256, 8);  // none for the next frame
      });

  EXPECT_THAT(
      rig.worker->Run(rig.EvaluationOrder({{1, 0, 4}}), *rig.snapshot).status(),
      StatusIs(absl::StatusCode::kFailedPrecondition,
               ::testing::HasSubstr("stopped while observing a body")));
  rig.worker->SetFrameObserver(nullptr);
  EXPECT_TRUE(rig.Run(rig.EvaluationOrder({{1, 0, 4}})).results(0).success());
}

}  // namespace
}  // namespace sinew::actor
