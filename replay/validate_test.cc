#include "replay/validate.h"

#include <cstring>
#include <functional>
#include <limits>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "common/segment/segment_layout.h"
#include "common/segment/segment_size.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "replay/testing/segments.h"

namespace sinew::replay {
namespace {

using Response = v1::PutSegmentResponse;
using ::sinew::testing::EqualsProto;
using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

// The verdict on a valid segment after a change.
Response JudgeChanged(const std::function<void(v1::Segment&)>& change) {
  v1::Segment segment = MakeSegment(7);
  change(segment);
  v1::Segment parsed;
  return Judge(MakeExpectation(7), segment.SerializeAsString(), parsed);
}

TEST(Judge, AcceptsWhatWasExpected) {
  v1::Segment parsed;

  const Response response =
      Judge(MakeExpectation(7), MakeSegmentBytes(7), parsed);

  EXPECT_EQ(response.verdict(), Response::VERDICT_ACCEPTED);
  EXPECT_EQ(response.order_id(), 7);
  EXPECT_THAT(parsed, EqualsProto(MakeSegment(7)));
}

TEST(Judge, RefusesBytesThatDoNotParse) {
  v1::Segment parsed;
  const std::string bytes = MakeSegmentBytes(7);

  const Response response =
      Judge(MakeExpectation(7), bytes.substr(0, bytes.size() / 2), parsed);

  EXPECT_EQ(response.verdict(), Response::VERDICT_MALFORMED);
  EXPECT_THAT(response.detail(), HasSubstr("do not parse"));
}

TEST(Judge, RefusesAnotherOrderRunOrIteration) {
  Response response = JudgeChanged([](auto& s) { s.set_order_id(8); });
  EXPECT_EQ(response.verdict(), Response::VERDICT_MALFORMED);
  EXPECT_EQ(response.detail(), "order_id: expected 7, found 8");
  response = JudgeChanged([](auto& s) { s.set_run_id("other"); });
  EXPECT_EQ(response.verdict(), Response::VERDICT_MALFORMED);
  EXPECT_EQ(response.detail(), "run_id: expected run, found other");
  response = JudgeChanged([](auto& s) { s.set_iteration(3); });
  EXPECT_EQ(response.verdict(), Response::VERDICT_MALFORMED);
  EXPECT_EQ(response.detail(), "iteration: expected 0, found 3");
}

TEST(Judge, RefusesAStaleSnapshot) {
  Response response = JudgeChanged([](auto& s) { s.set_snapshot_version(9); });
  EXPECT_EQ(response.verdict(), Response::VERDICT_STALE);
  EXPECT_EQ(response.detail(), "snapshot_version: expected 0, found 9");
  response = JudgeChanged([](auto& s) { s.set_snapshot_sha256("ab"); });
  EXPECT_EQ(response.verdict(), Response::VERDICT_STALE);
  EXPECT_THAT(response.detail(), HasSubstr("found ab"));
}

TEST(Judge, RefusesAnotherLayout) {
  Response response = JudgeChanged([](auto& s) { s.set_layout_sha256("x"); });
  EXPECT_EQ(response.verdict(), Response::VERDICT_LAYOUT);
  response = JudgeChanged([](auto& s) { s.mutable_columns()->RemoveLast(); });
  EXPECT_EQ(response.verdict(), Response::VERDICT_LAYOUT);
  response = JudgeChanged(
      [](auto& s) { Column(s, "reward").mutable_data()->pop_back(); });
  EXPECT_EQ(response.verdict(), Response::VERDICT_LAYOUT);
  EXPECT_THAT(response.detail(), HasSubstr("reward"));
}

TEST(Judge, RefusesAMissingEndState) {
  const Response response =
      JudgeChanged([](auto& s) { s.mutable_end_states()->RemoveLast(); });

  EXPECT_EQ(response.verdict(), Response::VERDICT_MALFORMED);
  EXPECT_EQ(response.detail(), "number of end_states: expected 2, found 1");
}

TEST(Judge, RefusesNumbersThatAreNotFinite) {
  Response response = JudgeChanged([](auto& s) {
    const float bad = std::numeric_limits<float>::quiet_NaN();
    std::memcpy(Column(s, "reward").mutable_data()->data() + sizeof(bad), &bad,
                sizeof(bad));
  });
  EXPECT_EQ(response.verdict(), Response::VERDICT_NON_FINITE);
  EXPECT_THAT(response.detail(), HasSubstr("reward[1]"));
  response = JudgeChanged([](auto& s) {
    s.mutable_end_states(1)->set_physics(
        0, std::numeric_limits<double>::infinity());
  });
  EXPECT_EQ(response.verdict(), Response::VERDICT_NON_FINITE);
  EXPECT_THAT(response.detail(), HasSubstr("end_states[1]"));
  response = JudgeChanged([](auto& s) {
    s.mutable_end_states(0)->set_goal_distance(
        std::numeric_limits<double>::quiet_NaN());
  });
  EXPECT_EQ(response.verdict(), Response::VERDICT_NON_FINITE);
  EXPECT_THAT(response.detail(), HasSubstr("end_states[0]"));
  response = JudgeChanged([](auto& s) {
    v1::EpisodeEnd& episode = *s.add_episodes();
    episode.set_steps(1);
    episode.set_episode_return(std::numeric_limits<double>::quiet_NaN());
  });
  EXPECT_EQ(response.verdict(), Response::VERDICT_NON_FINITE);
  EXPECT_THAT(response.detail(), HasSubstr("episodes[0]"));
  response = JudgeChanged([](auto& s) {
    s.mutable_seconds()->set_infer(std::numeric_limits<double>::quiet_NaN());
  });
  EXPECT_EQ(response.verdict(), Response::VERDICT_NON_FINITE);
  EXPECT_EQ(response.detail(), "seconds: expected finite numbers");
}

TEST(Judge, RefusesErrorsThatAreNotFinite) {
  Expectation expectation = MakeExpectation(7);
  expectation.expected.set_steps(0);
  expectation.expected.set_environments(1);
  v1::Segment segment = MakeSegment(7), parsed;
  segment.clear_columns();
  segment.clear_end_states();
  v1::EvaluationResult& result = *segment.add_results();
  result.add_sum_body_mm(1);
  result.add_sum_body_mm(std::numeric_limits<double>::quiet_NaN());

  const Response response =
      Judge(expectation, segment.SerializeAsString(), parsed);

  EXPECT_EQ(response.verdict(), Response::VERDICT_NON_FINITE);
  EXPECT_EQ(response.detail(), "results[0]: expected finite numbers");
}

TEST(Judge, ChecksNoColumnsOfAnEvaluation) {
  Expectation expectation = MakeExpectation(7);
  expectation.expected.set_steps(0);
  expectation.layout = nullptr;
  v1::Segment segment = MakeSegment(7);
  segment.clear_columns();
  segment.clear_end_states();
  for (int i = 0; i < kEnvironments; ++i) segment.add_results()->set_frames(5);
  v1::Segment parsed;

  EXPECT_EQ(Judge(expectation, segment.SerializeAsString(), parsed).verdict(),
            Response::VERDICT_ACCEPTED);
  segment.mutable_results()->RemoveLast();
  EXPECT_EQ(Judge(expectation, segment.SerializeAsString(), parsed).detail(),
            "number of results: expected 2, found 1");
  // Flags of no environment.
  v1::Tensor& flags = *segment.add_columns();
  flags.set_name("terminated");
  flags.add_shape(1);
  flags.add_shape(0);
  flags.set_data("0");
  *segment.add_columns() = flags;
  segment.mutable_columns(1)->set_name("truncated");
  EXPECT_EQ(Judge(expectation, segment.SerializeAsString(), parsed).detail(),
            "columns: expected none of an evaluation, found 2");
  segment.clear_columns();
  segment.add_results();
  segment.add_end_states();
  EXPECT_EQ(Judge(expectation, segment.SerializeAsString(), parsed).detail(),
            "number of end_states: expected 0, found 1");
}

TEST(Judge, RefusesResultsThatNoEvaluationAskedFor) {
  const Response response = JudgeChanged([](auto& s) { s.add_results(); });

  EXPECT_EQ(response.verdict(), Response::VERDICT_MALFORMED);
  EXPECT_EQ(response.detail(), "number of results: expected 0, found 1");
}

TEST(Judge, RefusesFewerEpisodesThanItsRowsEnded) {
  // Environment 1 ends in rows 0 and 2.
  const auto judge = [](int64_t episode) {
    return JudgeChanged([episode](auto& segment) {
      for (int row : {0, 2}) {
        (*Column(segment, "terminated")
              .mutable_data())[row * kEnvironments + 1] = 1;
      }
      segment.mutable_end_states(1)->set_episode(episode);
    });
  };
  EXPECT_EQ(judge(2).verdict(), Response::VERDICT_ACCEPTED);
  EXPECT_EQ(judge(1).verdict(), Response::VERDICT_MALFORMED);
  EXPECT_THAT(judge(1).detail(),
              HasSubstr("end_states[1].episode: expected >= 2"));
}

TEST(Judge, SurvivesLayoutsWhoseFlagsAreNone) {
  // A learner may say that they are one for each environment, or numbers.
  for (const bool boundary : {true, false}) {
    v1::SegmentLayout layout;
    for (const char* name : {"terminated", "truncated"}) {
      v1::SegmentLayout::Column& column = *layout.add_columns();
      column.set_name(name);
      column.set_dtype(boundary ? v1::DATA_TYPE_UINT8 : v1::DATA_TYPE_FLOAT64);
      column.set_lead(boundary ? v1::SegmentLayout::LEAD_BOUNDARY
                               : v1::SegmentLayout::LEAD_STEP);
    }
    Expectation expectation = MakeExpectation(7);
    expectation.layout = std::make_shared<const v1::SegmentLayout>(layout);
    expectation.expected.set_layout_sha256(LayoutSha256(layout));
    v1::Segment segment = MakeSegment(7), parsed;
    segment.set_layout_sha256(LayoutSha256(layout));
    segment.clear_columns();
    for (const auto& column : layout.columns()) {
      v1::Tensor& tensor = *segment.add_columns();
      tensor.set_name(column.name());
      tensor.set_dtype(column.dtype());
      if (!boundary) tensor.add_shape(kSteps);
      tensor.add_shape(kEnvironments);
      tensor.set_data(std::string(
          (boundary ? 1 : kSteps * sizeof(double)) * kEnvironments, '\0'));
    }

    EXPECT_EQ(Judge(expectation, segment.SerializeAsString(), parsed).verdict(),
              Response::VERDICT_ACCEPTED)
        << boundary;
  }
}

TEST(Judge, SurvivesEveryTruncationAndBitFlip) {
  const std::string bytes = MakeSegmentBytes(7);
  const Expectation expectation = MakeExpectation(7);

  for (size_t i = 0; i < bytes.size(); ++i) {
    v1::Segment cut;
    EXPECT_NE(Judge(expectation, bytes.substr(0, i), cut).verdict(),
              Response::VERDICT_ACCEPTED);
    std::string flipped = bytes;
    flipped[i] = static_cast<char>(flipped[i] ^ (1 << (i % 8)));
    v1::Segment parsed;
    EXPECT_NE(Judge(expectation, flipped, parsed).verdict(),
              Response::VERDICT_UNSPECIFIED);
  }
}

TEST(CheckExpectation, NamesTheFieldThatIsWrong) {
  constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;
  EXPECT_THAT(CheckExpectation(MakeExpectation(7)), IsOk());

  Expectation wrong = MakeExpectation(7);
  wrong.expected.set_environments(0);
  EXPECT_THAT(CheckExpectation(wrong),
              StatusIs(kInvalid, HasSubstr("open order 7: environments: "
                                           "expected 1 to 2^20, found 0")));
  wrong = MakeExpectation(7);
  wrong.expected.set_steps(-1);
  EXPECT_THAT(CheckExpectation(wrong), StatusIs(kInvalid, HasSubstr("steps")));
  wrong = MakeExpectation(7);
  wrong.expected.set_snapshot_sha256("no");
  EXPECT_THAT(CheckExpectation(wrong),
              StatusIs(kInvalid, HasSubstr("snapshot_sha256")));
  wrong = MakeExpectation(7);
  wrong.layout = nullptr;
  EXPECT_THAT(CheckExpectation(wrong), StatusIs(kInvalid, HasSubstr("layout")));
  wrong = MakeExpectation(7);
  wrong.expected.set_layout_sha256("no");
  EXPECT_THAT(CheckExpectation(wrong),
              StatusIs(kInvalid, HasSubstr("layout_sha256")));
}

TEST(MaxSegmentBytes, IsOfResultsAloneForAnEvaluation) {
  Expectation expectation = MakeExpectation(7);
  EXPECT_EQ(MaxSegmentBytes(expectation),
            MaxTrainingBytes(TestLayout(), kEnvironments, kSteps));

  expectation.expected.set_steps(0);
  expectation.layout = nullptr;

  EXPECT_EQ(MaxSegmentBytes(expectation), MaxEvaluationBytes(kEnvironments));
}

}  // namespace
}  // namespace sinew::replay
