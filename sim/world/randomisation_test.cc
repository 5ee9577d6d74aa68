#include "sim/world/randomisation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "common/config/recipe.h"
#include "common/testing/matchers.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::world {
namespace {

using ::sinew::testing::StatusIs;
using ::testing::Each;
using ::testing::HasSubstr;

// A recipe with `text` as its randomisation.
v1::Recipe MakeRecipe(const std::string& text) {
  auto recipe = ParseRecipe("task { randomisation { " + text + " } }", "test");
  EXPECT_TRUE(recipe.ok()) << recipe.status();
  return WithDefaults(*recipe);
}

class RandomisationTest : public ::testing::Test {
 protected:
  Randomisation Make(const std::string& text) const {
    auto made = Randomisation::Create(MakeRecipe(text), *toy_.character);
    EXPECT_TRUE(made.ok()) << made.status();
    return *std::move(made);
  }
  static Conditions Draw(const Randomisation& random, uint64_t episode) {
    Conditions conditions = random.MakeConditions();
    random.Draw({.seed = 5, .environment = 6, .episode = episode}, &conditions);
    return conditions;
  }

  testing::ToyWorld toy_ = testing::MakeToyWorld();
};

TEST_F(RandomisationTest, IsOffUnlessSomethingIsRandomised) {
  EXPECT_FALSE(Make("").on());
  EXPECT_FALSE(Make("in_evaluation: true").on());
  EXPECT_TRUE(Make("gain: 0.1").on());
  EXPECT_TRUE(Make("push_impulse: 1 push_bodies: \"trunk\"").on());
}

TEST_F(RandomisationTest, DrawsEveryFieldOverItsWholeRange) {
  const Randomisation random =
      Make("mass: 0.1 friction: 0.5 joint_offset: 0.02 gain: 0.2");
  std::vector<double> masses, frictions, offsets, gains;
  for (uint64_t episode = 0; episode < 500; ++episode) {
    const Conditions drawn = Draw(random, episode);
    ASSERT_EQ(drawn.mass_scale.size(), 6);
    ASSERT_EQ(drawn.gain_scale.size(), 4);
    masses.push_back(drawn.mass_scale[2]);
    frictions.push_back(drawn.friction_scale);
    offsets.push_back(drawn.joint_offset[3]);
    gains.push_back(drawn.gain_scale[3]);
    EXPECT_NE(drawn.mass_scale[1], drawn.mass_scale[2]);
    EXPECT_NE(drawn.gain_scale[0], drawn.gain_scale[1]);
  }

  // None of 500 in the outer 2.5 % on a side: once in 300000 times.
  const auto expect_range = [](const std::vector<double>& drawn, double middle,
                               double half) {
    const auto [low, high] = std::minmax_element(drawn.begin(), drawn.end());
    EXPECT_GE(*low, middle - half);
    EXPECT_LE(*high, middle + half);
    EXPECT_NEAR(*low, middle - half, 0.05 * half);
    EXPECT_NEAR(*high, middle + half, 0.05 * half);
  };
  expect_range(masses, 1, 0.1);
  expect_range(frictions, 1, 0.5);
  expect_range(offsets, 0, 0.02);
  expect_range(gains, 1, 0.2);
}

TEST_F(RandomisationTest, IsAFunctionOfSeedEnvironmentAndEpisode) {
  const Randomisation random = Make("mass: 0.1");
  Conditions at_step = random.MakeConditions();
  random.Draw({.seed = 5, .environment = 6, .episode = 1, .step = 44},
              &at_step);

  EXPECT_EQ(at_step.mass_scale, Draw(random, 1).mass_scale);
  EXPECT_NE(at_step.mass_scale, Draw(random, 2).mass_scale);
}

TEST_F(RandomisationTest, LeavesWhatIsOff) {
  const Conditions drawn = Draw(Make("mass: 0.1"), 0);

  EXPECT_EQ(drawn.friction_scale, 1);
  EXPECT_THAT(drawn.joint_offset, Each(0));
  EXPECT_THAT(drawn.gain_scale, Each(1));
  EXPECT_EQ(Make("mass: 0.1").PushAt(drawn, 3).body, 0);
}

TEST_F(RandomisationTest, PushesOnceInEveryInterval) {
  // At 30 Hz: 3 steps in every 15.
  const Randomisation random = Make(
      "push_impulse: 6 push_interval: 0.5 push_seconds: 0.1 "
      "push_bodies: [\"trunk\", \"leg_br\"]");
  const Conditions conditions = Draw(random, 0);
  std::set<int> bodies, begins;
  double largest = 0, up = 0;
  for (int interval = 0; interval < 200; ++interval) {
    int pushed = 0, begin = -1;
    for (int step = 0; step < 15; ++step) {
      const Push push = random.PushAt(conditions, 15 * interval + step);
      if (push.body == 0) continue;
      if (begin < 0) begin = step;
      EXPECT_EQ(step, begin + pushed);
      ++pushed;
      bodies.insert(push.body);
      const double impulse = mju_norm3(push.force) * 0.1;
      EXPECT_LE(impulse, 6 + 1e-12);
      largest = std::max(largest, impulse);
      up += push.force[2] > 0 ? 1 : 0;
    }
    EXPECT_EQ(pushed, 3) << interval;
    begins.insert(begin);
  }

  EXPECT_EQ(bodies, (std::set<int>{1, 5}));
  EXPECT_EQ(begins.size(), 13);  // 0 to 12
  EXPECT_GT(largest, 5.7);
  EXPECT_NEAR(up / 600, 0.5, 0.15);
}

TEST_F(RandomisationTest, PushesRootHeadHandsAndFeetOfAHumanoid) {
  const v1::Recipe recipe = MakeRecipe("push_impulse: 6");
  const auto humanoid =
      character::Character::Load("humanoid", recipe.physics());
  ASSERT_TRUE(humanoid.ok()) << humanoid.status();
  const auto random = Randomisation::Create(recipe, **humanoid);
  ASSERT_TRUE(random.ok()) << random.status();
  Conditions conditions = random->MakeConditions();
  random->Draw({.seed = 1}, &conditions);

  std::set<int> bodies;
  for (int step = 0; step < 60 * 100; ++step) {
    const Push push = random->PushAt(conditions, step);
    if (push.body > 0) bodies.insert(push.body);
  }

  EXPECT_EQ(bodies.size(), 6);
  EXPECT_TRUE(bodies.contains(1));
  EXPECT_TRUE(bodies.contains((*humanoid)->head_body()));
  for (int foot : (*humanoid)->foot_bodies()) {
    EXPECT_TRUE(bodies.contains(foot));
  }
}

TEST_F(RandomisationTest, NamesAPushBodyThatTheCharacterHasNot) {
  EXPECT_THAT(
      Randomisation::Create(MakeRecipe("push_impulse: 1 push_bodies: \"tail\""),
                            *toy_.character)
          .status(),
      StatusIs(absl::StatusCode::kInvalidArgument,
               "recipe field task.randomisation.push_bodies: expected bodies "
               "of character toy, found \"tail\""));
  // A table has no hands.
  EXPECT_THAT(
      Randomisation::Create(MakeRecipe("push_impulse: 1"), *toy_.character)
          .status(),
      StatusIs(absl::StatusCode::kFailedPrecondition));
}

}  // namespace
}  // namespace sinew::world
