// Segments against what a run's states may hold.
#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "gtest/gtest.h"
#include "proto/sinew/v1/state_limits.pb.h"
#include "replay/testing/segments.h"
#include "replay/validate.h"

namespace sinew::replay {
namespace {

using Response = v1::PutSegmentResponse;

// Three clips of ten frames; two numbers of physics and one joint.
std::shared_ptr<const v1::StateLimits> Limits() {
  auto limits = std::make_shared<v1::StateLimits>();
  for (int i = 0; i < 3; ++i) limits->add_clips()->set_start_frames(9);
  limits->set_state_size(2);
  limits->set_joints(1);
  limits->set_max_episode_steps(100);
  return limits;
}

// What is said against a segment after a change; empty: it was accepted.
std::string DetailWithin(std::shared_ptr<const v1::StateLimits> limits,
                         const std::function<void(v1::Segment&)>& change) {
  Expectation expectation = MakeExpectation(7);
  expectation.limits = std::move(limits);
  v1::Segment segment = MakeSegment(7), parsed;
  segment.mutable_end_states(0)->Clear();  // begins anew
  v1::EnvironmentState& state = *segment.mutable_end_states(1);
  state.clear_physics();
  for (int i = 0; i < 2; ++i) state.add_physics(0.5);
  state.add_previous_target(0.1);
  state.set_clip(2);
  state.set_start_frame(3);
  state.set_step(5);
  v1::EpisodeEnd& episode = *segment.add_episodes();
  episode.set_clip(2);
  episode.set_steps(1);
  change(segment);
  const Response response =
      Judge(expectation, segment.SerializeAsString(), parsed);
  EXPECT_EQ(response.verdict(), response.detail().empty()
                                    ? Response::VERDICT_ACCEPTED
                                    : Response::VERDICT_MALFORMED);
  return response.detail();
}

// The same after a change of its episode.
std::string EpisodeDetail(std::shared_ptr<const v1::StateLimits> limits,
                          const std::function<void(v1::EpisodeEnd&)>& change) {
  return DetailWithin(std::move(limits), [&change](v1::Segment& segment) {
    change(*segment.mutable_episodes(0));
  });
}

TEST(Judge, RefusesPlacesThatTheLibraryDoesNotHave) {
  const auto detail = [](auto change) {
    return EpisodeDetail(Limits(), change);
  };
  EXPECT_EQ(detail([](auto&) {}), "");
  EXPECT_EQ(detail([](auto& episode) { episode.set_clip(3); }),
            "episodes[0].clip: expected 0 to 2, found 3");
  EXPECT_EQ(detail([](auto& episode) { episode.set_start_frame(9); }),
            "episodes[0].start_frame: expected 0 to 8, found 9");
  EXPECT_EQ(detail([](auto& episode) { episode.set_steps(10); }),
            "episodes[0].steps: expected 1 to 9, found 10");
}

TEST(Judge, ChecksLessForALearnerThatSaysNoLimits) {
  const auto detail = [](auto change) {
    return EpisodeDetail(nullptr, change);
  };
  EXPECT_EQ(detail([](auto& episode) { episode.set_clip(3); }), "");
  EXPECT_EQ(detail([](auto& episode) { episode.set_start_frame(-1); }),
            "episodes[0]: expected clip and start_frame >= 0, found 2 and -1");
  EXPECT_EQ(detail([](auto& episode) { episode.set_steps(0); }),
            "episodes[0].steps: expected >= 1, found 0");
}

TEST(Judge, RefusesStatesThatNoRolloutCanGoOnFrom) {
  const auto detail = [](auto change) {
    return DetailWithin(Limits(), [&](auto& segment) {
      change(*segment.mutable_end_states(1));
    });
  };
  EXPECT_EQ(detail([](auto& state) { state.add_physics(0); }),
            "end_states[1].physics: expected 2 numbers, found 3");
  EXPECT_EQ(detail([](auto& state) { state.set_step(6); }),
            "end_states[1].step: expected 0 to 5, found 6");
}

TEST(Judge, RefusesRowsOfAClipThatIsNotThere) {
  const auto detail = [](int32_t clip) {
    return DetailWithin(Limits(), [clip](auto& segment) {
      std::string& data = *Column(segment, "clip").mutable_data();
      std::memcpy(data.data() + 2 * sizeof(clip), &clip, sizeof(clip));
    });
  };
  EXPECT_EQ(detail(2), "");
  EXPECT_EQ(detail(3), "segment column clip[2]: expected 0 to 2, found 3");
  EXPECT_EQ(detail(-1), "segment column clip[2]: expected 0 to 2, found -1");
}

TEST(Judge, RefusesAResultOfAClipThatIsNotThere) {
  Expectation expectation = MakeExpectation(7);
  expectation.expected.set_steps(0);
  expectation.expected.set_environments(1);
  expectation.limits = Limits();
  expectation.layout = nullptr;
  v1::Segment segment = MakeSegment(7), parsed;
  segment.clear_columns();
  segment.clear_end_states();
  v1::EvaluationResult& result = *segment.add_results();
  result.set_clip(3);
  EXPECT_EQ(Judge(expectation, segment.SerializeAsString(), parsed).detail(),
            "results[0].clip: expected 0 to 2, found 3");

  result.set_clip(2);
  result.add_carried()->set_start_frame(9);
  EXPECT_EQ(Judge(expectation, segment.SerializeAsString(), parsed).detail(),
            "results[0].carried[0].start_frame: expected 0 to 8, found 9");
}

}  // namespace
}  // namespace sinew::replay
