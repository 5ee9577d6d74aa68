#include "sim/world/nearest_frame.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "common/testing/allocation_count.h"
#include "sim/world/testing/random_state.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::world {
namespace {

using testing::Moved;

constexpr int kTurn = 0, kSway = 1, kTumble = 2;

class NearestFramesTest : public ::testing::Test {
 protected:
  NearestFramesTest()
      : toy_(testing::MakeToyWorld()), reader_(*toy_.character) {
    Index();
  }

  // Of the library as it is now.
  void Index(int64_t most = NearestFrames::kMostFrames,
             double seconds = NearestFrames::kSecondsAhead) {
    frames_.emplace(toy_.recipe.task().start(), *toy_.library, reader_, seconds,
                    most);
    scratch_.resize(frames_->width());
  }

  BodyState At(int clip, int frame) const {
    BodyState body(reader_.num_bodies(), reader_.num_joints());
    reader_.Read(toy_.library->frame(clip, frame), &body);
    return body;
  }
  std::pair<int, int> Find(const BodyState& body) {
    const std::optional<StartFrame> found =
        frames_->Find(body, absl::MakeSpan(scratch_));
    if (!found.has_value()) return {-1, -1};
    return {found->clip, found->frame};
  }

  testing::ToyWorld toy_;
  const BodyReader reader_;
  std::optional<NearestFrames> frames_;
  std::vector<float> scratch_;
};

TEST_F(NearestFramesTest, FindsAFrameWhereverTheBodyIsInThePlane) {
  for (const auto& [clip, frame] :
       std::vector<std::pair<int, int>>{{kTurn, 0}, {kTurn, 23}, {kSway, 3}}) {
    EXPECT_EQ(Find(Moved(At(clip, frame), 2.5, {3, -7, 0})),
              std::make_pair(clip, frame));
  }
}

TEST_F(NearestFramesTest, HeightAndVelocityCount) {
  BodyState still = At(kTurn, 6);
  const std::pair<int, int> moving = Find(still);
  EXPECT_EQ(moving, std::make_pair(kTurn, 6));
  for (Eigen::Vector3d& velocity : still.linear_velocity) velocity.setZero();
  EXPECT_NE(Find(still), moving);

  // In the air, where only the tumble goes.
  ASSERT_EQ(Find(Moved(At(kTumble, 0), 0, {0, 0, 0})),
            std::make_pair(kTumble, 0));
  EXPECT_EQ(Find(Moved(At(kSway, 2), 0, {0, 0, 2})).first, kTumble);
}

// The sway has 20 frames, the tumble 16: five and one are followed by 15.
TEST_F(NearestFramesTest, LeavesOutTheEndsOfClipsThatDoNotLoop) {
  EXPECT_EQ(frames_->size(), 24 + 5 + 1);
  EXPECT_EQ(Find(At(kSway, 4)), std::make_pair(kSway, 4));
  EXPECT_NE(Find(At(kSway, 5)), std::make_pair(kSway, 5));

  // Of 0.3 s that is 9 frames, of a second none.
  Index(NearestFrames::kMostFrames, /*seconds=*/0.3);
  EXPECT_EQ(frames_->size(), 24 + 11 + 7);
  EXPECT_EQ(Find(At(kSway, 5)), std::make_pair(kSway, 5));
  Index(NearestFrames::kMostFrames, /*seconds=*/1);
  EXPECT_EQ(frames_->size(), 24);
}

TEST_F(NearestFramesTest, LeavesOutWhatTrainingDoes) {
  testing::LeaveOut({kTurn}, toy_);
  Index();

  EXPECT_EQ(frames_->size(), 6);
  EXPECT_NE(Find(At(kTurn, 6)).first, kTurn);

  testing::LeaveOut({kTurn, kSway, kTumble}, toy_);
  Index();
  EXPECT_EQ(Find(At(kTurn, 6)).first, -1);
}

TEST_F(NearestFramesTest, KeepsEveryNthWhereThereAreTooMany) {
  Index(30);
  EXPECT_EQ(frames_->size(), 30);

  // Every third of 30.
  Index(12);

  EXPECT_EQ(frames_->size(), 10);
  EXPECT_EQ(Find(At(kTurn, 6)), std::make_pair(kTurn, 6));
  const auto [clip, frame] = Find(At(kTurn, 7));
  EXPECT_EQ(clip, kTurn);
  EXPECT_EQ(frame % 3, 0);
}

TEST_F(NearestFramesTest, ABodyThatIsNotFiniteHasNone) {
  BodyState body = At(kTurn, 6);
  body.position[1].x() = std::numeric_limits<double>::quiet_NaN();

  EXPECT_EQ(Find(body).first, -1);
}

TEST_F(NearestFramesTest, DoesNotAllocate) {
  const BodyState body = At(kTurn, 6);
  const int64_t before = sinew::testing::AllocationCount();
  const std::optional<StartFrame> found =
      frames_->Find(body, absl::MakeSpan(scratch_));
  EXPECT_EQ(sinew::testing::AllocationCount(), before);
  EXPECT_TRUE(found.has_value());
}

}  // namespace
}  // namespace sinew::world
