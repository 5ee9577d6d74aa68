#include "common/segment/state_limits.h"

#include <functional>
#include <limits>
#include <string>

#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "proto/sinew/v1/state_limits.pb.h"

namespace sinew {
namespace {

using ::sinew::testing::IsOk;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// A clip of ten frames, and one of five that loops.
v1::StateLimits MakeLimits() {
  v1::StateLimits limits;
  limits.add_clips()->set_start_frames(9);
  v1::StateLimits::Clip& loop = *limits.add_clips();
  loop.set_start_frames(5);
  loop.set_loops(true);
  limits.set_state_size(3);
  limits.set_joints(2);
  limits.set_max_episode_steps(20);
  limits.set_recovery_steps(4);
  return limits;
}

v1::EnvironmentState MakeState() {
  v1::EnvironmentState state;
  for (int i = 0; i < 3; ++i) state.add_physics(i);
  for (int i = 0; i < 2; ++i) state.add_previous_target(i);
  state.set_start_frame(4);
  state.set_step(2);
  return state;
}

// What is said against a state after a change; empty: nothing.
std::string Against(const std::function<void(v1::EnvironmentState&)>& change) {
  v1::EnvironmentState state = MakeState();
  change(state);
  return std::string(CheckState(state, MakeLimits()).message());
}

TEST(CheckState, AcceptsWhatARolloutLeaves) {
  EXPECT_THAT(CheckState(MakeState(), MakeLimits()), IsOk());
}

TEST(CheckState, LooksAtTheEpisodeAloneWhereItBeginsAnew) {
  v1::EnvironmentState state;
  state.set_episode(3);
  state.set_clip(99);
  EXPECT_THAT(CheckState(state, MakeLimits()), IsOk());
  state.set_episode(-1);
  EXPECT_EQ(CheckState(state, MakeLimits()).message(),
            "episode: expected >= 0, found -1");
}

TEST(CheckState, NamesTheNumbersThatAreWrong) {
  EXPECT_EQ(Against([](auto& s) { s.add_physics(0); }),
            "physics: expected 3 numbers, found 4");
  EXPECT_EQ(Against([](auto& s) { s.set_physics(1, kNan); }),
            "physics[1]: expected a finite number, found nan");
  EXPECT_EQ(Against([](auto& s) { s.clear_previous_target(); }),
            "previous_target: expected 2 numbers, found 0");
  EXPECT_EQ(Against([](auto& s) { s.set_episode_error(kNan); }),
            "episode_return and episode_error: expected finite numbers, found "
            "0 and nan");
}

TEST(CheckState, NamesThePlaceThatTheLibraryLacks) {
  EXPECT_EQ(Against([](auto& s) { s.set_clip(2); }),
            "clip: expected 0 to 1, found 2");
  EXPECT_EQ(Against([](auto& s) { s.set_clip(-1); }),
            "clip: expected 0 to 1, found -1");
  EXPECT_EQ(Against([](auto& s) { s.set_start_frame(9); }),
            "start_frame: expected 0 to 8, found 9");
}

TEST(CheckState, BoundsStepsByTheClipsEndAndTheEpisodes) {
  EXPECT_EQ(Against([](auto& s) { s.set_step(4); }), "");
  EXPECT_EQ(Against([](auto& s) { s.set_step(5); }),
            "step: expected 0 to 4, found 5");
  EXPECT_EQ(Against([](auto& s) { s.set_step(-1); }),
            "step: expected >= 0, found -1");
  const auto looping = [](int step) {
    return [step](v1::EnvironmentState& state) {
      state.set_clip(1);
      state.set_step(step);
    };
  };
  EXPECT_EQ(Against(looping(19)), "");
  EXPECT_EQ(Against(looping(20)), "step: expected 0 to 19, found 20");
  // Steps in which the reference stood do not count.
  EXPECT_EQ(Against([](auto& s) {
              s.set_step(7);
              s.set_frozen_steps(3);
            }),
            "");
}

TEST(CheckState, BoundsWhatIsLeftOfARecovery) {
  EXPECT_EQ(Against([](auto& s) { s.set_recovery_steps_left(5); }),
            "recovery_steps_left: expected 0 to 4, found 5");
  EXPECT_EQ(Against([](auto& s) { s.set_frozen_steps(3); }),
            "frozen_steps: expected 0 to 2, found 3");
  EXPECT_EQ(Against([](auto& s) {
              s.set_recovery_steps_left(3);
              s.set_frozen_steps(2);
            }),
            "frozen_steps: expected 0 to 1, found 2");
  EXPECT_EQ(Against([](auto& s) { s.set_goal_distance(-1); }),
            "goal_distance: expected >= 0, found -1");
  EXPECT_EQ(
      Against([](auto& s) { s.set_start_kind(static_cast<v1::StartKind>(9)); }),
      "start_kind: expected 0 to 4, found 9");
}

TEST(CheckPlace, NamesTheFrame) {
  EXPECT_THAT(CheckPlace(1, 4, MakeLimits()), IsOk());
  EXPECT_EQ(CheckPlace(1, 5, MakeLimits()).message(),
            "start_frame: expected 0 to 4, found 5");
  EXPECT_EQ(CheckPlace(0, -1, MakeLimits()).message(),
            "start_frame: expected 0 to 8, found -1");
}

TEST(CheckEpisode, BoundsItsSteps) {
  v1::EpisodeEnd episode;
  episode.set_start_frame(3);
  const auto against = [&episode](int steps) {
    episode.set_steps(steps);
    return std::string(CheckEpisode(episode, MakeLimits()).message());
  };
  // Six to the clip's end, and four in which the reference may stand.
  EXPECT_EQ(against(10), "");
  EXPECT_EQ(against(11), "steps: expected 1 to 10, found 11");
  EXPECT_EQ(against(0), "steps: expected 1 to 10, found 0");
  episode.set_clip(1);
  EXPECT_EQ(against(24), "");
  EXPECT_EQ(against(25), "steps: expected 1 to 24, found 25");
  episode.set_clip(2);
  EXPECT_EQ(against(1), "clip: expected 0 to 1, found 2");
}

TEST(CheckSegment, NamesTheItemThatIsWrong) {
  v1::Segment good;
  good.add_end_states()->set_episode(2);
  *good.add_end_states() = MakeState();
  good.add_episodes()->set_steps(9);
  good.add_results()->add_carried()->set_start_frame(8);
  EXPECT_THAT(CheckSegment(good, MakeLimits()), IsOk());
  const auto against = [&good](auto change) {
    v1::Segment segment = good;
    change(segment);
    return std::string(CheckSegment(segment, MakeLimits()).message());
  };
  EXPECT_EQ(against([](auto& s) { s.mutable_end_states(1)->set_step(5); }),
            "end_states[1].step: expected 0 to 4, found 5");
  EXPECT_EQ(against([](auto& s) { s.mutable_episodes(0)->set_clip(2); }),
            "episodes[0].clip: expected 0 to 1, found 2");
  EXPECT_EQ(against([](auto& s) { s.mutable_results(0)->set_clip(-1); }),
            "results[0].clip: expected 0 to 1, found -1");
  EXPECT_EQ(against([](auto& s) {
              s.mutable_results(0)->mutable_carried(0)->set_start_frame(9);
            }),
            "results[0].carried[0].start_frame: expected 0 to 8, found 9");
}

TEST(CheckLimits, NamesTheFieldThatIsWrong) {
  EXPECT_THAT(CheckLimits(MakeLimits()), IsOk());
  const auto against = [](auto change) {
    v1::StateLimits limits = MakeLimits();
    change(limits);
    return std::string(CheckLimits(limits).message());
  };
  EXPECT_EQ(against([](auto& l) { l.clear_clips(); }),
            "limits.clips: expected >= 1, found 0");
  EXPECT_EQ(against([](auto& l) { l.mutable_clips(1)->set_start_frames(0); }),
            "limits.clips[1].start_frames: expected >= 1, found 0");
  EXPECT_EQ(against([](auto& l) { l.set_state_size(0); }),
            "limits.state_size: expected >= 1, found 0");
  EXPECT_EQ(against([](auto& l) { l.set_joints(0); }),
            "limits.joints: expected >= 1, found 0");
  EXPECT_EQ(against([](auto& l) { l.set_max_episode_steps(0); }),
            "limits.max_episode_steps: expected >= 1, found 0");
  EXPECT_EQ(against([](auto& l) { l.set_recovery_steps(-1); }),
            "limits.recovery_steps: expected >= 0, found -1");
}

}  // namespace
}  // namespace sinew
