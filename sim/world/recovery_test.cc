#include "sim/world/recovery.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "common/config/recipe.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::world {
namespace {

v1::Recovery MakeRecovery(double fallen_share, double far_share,
                          double get_up_share = 0) {
  v1::Recipe recipe;
  v1::Recovery* recovery = recipe.mutable_task()->mutable_recovery();
  recovery->set_fallen_share(fallen_share);
  recovery->set_far_share(far_share);
  recovery->set_get_up_share(get_up_share);
  return WithDefaults(recipe).task().recovery();
}

// Starts of 4000 episodes.
std::vector<BodyStart> Draw(const v1::Recovery& recovery) {
  std::vector<BodyStart> starts;
  for (uint64_t episode = 0; episode < 4000; ++episode) {
    starts.push_back(RecoveryLaw(recovery).Draw(
        {.seed = 7, .environment = 3, .episode = episode}, 16));
  }
  return starts;
}

TEST(RecoveryLaw, IsOffUnlessAShareIsPositive) {
  EXPECT_FALSE(RecoveryLaw(v1::Recovery()).on());
  EXPECT_TRUE(RecoveryLaw(MakeRecovery(0.1, 0)).on());
  EXPECT_TRUE(RecoveryLaw(MakeRecovery(0, 0.1)).on());
  EXPECT_TRUE(RecoveryLaw(MakeRecovery(0, 0, 0.1)).on());
}

TEST(RecoveryLaw, MixesStartsByTheirShares) {
  int fallen = 0, far = 0, get_up = 0;
  std::vector<int> states(16), of_get_ups(16);
  for (const BodyStart& start : Draw(MakeRecovery(0.3, 0.2, 0.1))) {
    int steps = 0;
    switch (start.kind) {
      case v1::START_KIND_FALLEN:
        ++fallen;
        ++states.at(start.fallen_state);
        steps = 90;
        break;
      case v1::START_KIND_FAR:
        ++far;
        steps = 90;
        break;
      case v1::START_KIND_GET_UP:
        ++get_up;
        ++of_get_ups.at(start.fallen_state);
        steps = 20;
        break;
      default:
        break;
    }
    EXPECT_EQ(start.recovery_steps, steps);
  }

  // Four standard deviations of a share of 4000 are 0.029, 0.025 and 0.019.
  EXPECT_NEAR(fallen / 4000.0, 0.3, 0.029);
  EXPECT_NEAR(far / 4000.0, 0.2, 0.025);
  EXPECT_NEAR(get_up / 4000.0, 0.1, 0.019);
  EXPECT_THAT(states, ::testing::Each(::testing::Gt(30)));     // 75 each
  EXPECT_THAT(of_get_ups, ::testing::Each(::testing::Gt(5)));  // 25 each
}

TEST(RecoveryLaw, SpreadsFarStartsEvenlyOverADisc) {
  int inner = 0, left = 0, within_half_turn = 0;
  for (const BodyStart& start : Draw(MakeRecovery(0, 1))) {
    const double distance = std::hypot(start.offset_x, start.offset_y);
    EXPECT_LE(distance, 5);
    // A disc of half the radius has a quarter of the area.
    if (distance < 2.5) ++inner;
    if (start.offset_x < 0) ++left;
    if (start.turn < M_PI) ++within_half_turn;
  }

  EXPECT_NEAR(inner / 4000.0, 0.25, 0.028);
  EXPECT_NEAR(left / 4000.0, 0.5, 0.032);
  EXPECT_NEAR(within_half_turn / 4000.0, 0.5, 0.032);
}

TEST(RecoveryLaw, DrawsTheSameForTheSameEpisodeWhateverTheKeysStep) {
  const RecoveryLaw law(MakeRecovery(0.5, 0.5));
  RandomKey key{.seed = 1, .environment = 2, .episode = 3};
  const BodyStart one = law.Draw(key, 16);
  key.step = 9;
  const BodyStart other = law.Draw(key, 16);

  EXPECT_EQ(one.kind, other.kind);
  EXPECT_EQ(one.turn, other.turn);
  EXPECT_EQ(one.offset_x, other.offset_x);
}

TEST(RecoveryLaw, RewardsTheGainInDistanceAndTrackingWhereItIsNear) {
  const RecoveryLaw law(MakeRecovery(0.5, 0));

  // 9 * 0.1; 9 * 1/3, the most; 9 * -0.5; 9 * 0.05 + 0.5 * 0.8.
  EXPECT_NEAR(law.Reward(0.8, 2.1, 2.0), 0.9, 1e-12);
  EXPECT_NEAR(law.Reward(0.8, 5, 2), 3, 1e-12);
  EXPECT_NEAR(law.Reward(0.8, 2, 2.5), -4.5, 1e-12);
  EXPECT_NEAR(law.Reward(0.8, 0.25, 0.20), 0.85, 1e-12);
}

TEST(RecoveryLaw, ShowsOnlyTheDirectionOfAReferenceThatIsFar) {
  BodyState body(2, 1);
  body.position = {{1, 0, 0.5}, {1, 0, 1}};
  body.joint_position = {0.7};
  BodyState reference(2, 1);
  reference.position = {{1, 12, 0.5}, {2, 12, 1}};
  reference.linear_velocity[0] = {1, 2, 3};

  ASSERT_TRUE(RecoveryLaw(MakeRecovery(0.5, 0)).Hide(body, &reference));

  EXPECT_TRUE(reference.position[0].isApprox(Eigen::Vector3d(1, 3, 0.5)));
  EXPECT_TRUE(reference.position[1].isApprox(Eigen::Vector3d(1, 3, 1)));
  EXPECT_EQ(reference.linear_velocity[0], body.linear_velocity[0]);
  EXPECT_EQ(reference.joint_position[0], 0.7);
}

TEST(RecoveryLaw, LeavesAReferenceThatIsNear) {
  const BodyState body(1, 0);
  BodyState reference(1, 0);
  reference.position[0] = {0, 2.9, 0};
  reference.linear_velocity[0] = {1, 0, 0};

  EXPECT_FALSE(RecoveryLaw(MakeRecovery(0.5, 0)).Hide(body, &reference));
  EXPECT_EQ(reference.position[0], Eigen::Vector3d(0, 2.9, 0));
  EXPECT_EQ(reference.linear_velocity[0], Eigen::Vector3d(1, 0, 0));
}

class RecoveryWatchTest : public ::testing::Test {
 protected:
  // The toy's head is its root.
  void Add(double distance, double height, double reference_height = 1) {
    BodyState body(5, 4), reference(5, 4);
    body.position[0].z() = height;
    reference.position[0].z() = reference_height;
    watch_.Add(distance, body, reference);
  }

  testing::ToyWorld toy_ = testing::MakeToyWorld();
  RecoveryWatch watch_{*toy_.character, 0.5};
};

TEST_F(RecoveryWatchTest, NamesTheFirstFrameOfTheStretchThatLasts) {
  Add(0.4, 0.9);  // holds, but not for long
  Add(0.6, 0.9);  // too far off
  Add(0.4, 0.7);  // lies
  EXPECT_EQ(watch_.recovered_at(), -1);

  Add(0.4, 0.85);
  Add(0.1, 1.2);

  EXPECT_EQ(watch_.recovered_at(), 4);
}

TEST_F(RecoveryWatchTest, DoesNotCountWhileTheReferenceLies) {
  Add(0.1, 0.3, 0.3);  // below 0.8 of 0.44
  EXPECT_EQ(watch_.recovered_at(), -1);
  Add(0.1, 0.36, 0.36);
  Add(0.1, 0.44, 0.44);

  EXPECT_EQ(watch_.recovered_at(), 2);
}

TEST_F(RecoveryWatchTest, CountsADistanceThatIsNoNumberAsLost) {
  Add(0.1, 1);
  Add(std::numeric_limits<double>::quiet_NaN(), 1);

  EXPECT_EQ(watch_.recovered_at(), -1);
}

}  // namespace
}  // namespace sinew::world
