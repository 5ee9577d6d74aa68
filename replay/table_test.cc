#include "replay/table.h"

#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "common/metrics/registry.h"
#include "common/metrics/testing/lint.h"
#include "common/testing/matchers.h"
#include "common/testing/simulated_clock.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "proto/sinew/v1/state_limits.pb.h"
#include "replay/testing/segments.h"
#include "replay/validate.h"

namespace sinew::replay {
namespace {

using Response = v1::PutSegmentResponse;
using ::sinew::testing::EqualsProto;
using ::sinew::testing::IsOk;
using ::sinew::testing::SimulatedClock;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

constexpr auto kNever = [] { return false; };

// A table with its metrics.
struct Fixture {
  explicit Fixture(int64_t limit_bytes = int64_t{1} << 30)
      : registry({.role = "replay", .build = ""}),
        metrics(registry),
        table({.limit_bytes = limit_bytes, .clock = &clock}, metrics) {}

  Table::Admission Admit(int64_t order_id, int64_t size) {
    auto admission =
        table.Admit(kRun, order_id, size, absl::InfiniteFuture(), kNever);
    EXPECT_THAT(admission, IsOk());
    return *std::move(admission);
  }

  Response::Verdict Put(int64_t order_id, const std::string& bytes) {
    Table::Admission admission =
        Admit(order_id, static_cast<int64_t>(bytes.size()));
    if (admission.refusal.has_value()) return admission.refusal->verdict();
    return table.Put(std::move(admission.room), bytes).verdict();
  }

  absl::StatusOr<std::vector<SegmentPtr>> Collect(
      const std::vector<int64_t>& ids, absl::Time deadline) {
    return table.Collect(kRun, ids, deadline, kNever);
  }

  SimulatedClock clock;
  metrics::Registry registry;
  ReplayMetrics metrics;
  Table table;
};

// Largest size that a segment of one test order may have.
int64_t Most() { return MaxSegmentBytes(MakeExpectation(0)); }

TEST(Table, GivesBackWhatWasPutInOrderOfIds) {
  Fixture f;
  ASSERT_THAT(f.table.Open(MakeOpen({1, 2, 3}, 0, /*reset=*/true)), IsOk());
  for (int64_t id : {3, 1, 2}) {
    EXPECT_EQ(f.Put(id, MakeSegmentBytes(id)), Response::VERDICT_ACCEPTED);
  }

  const auto segments = f.Collect({3, 2, 1}, absl::InfiniteFuture());

  ASSERT_THAT(segments, IsOk());
  ASSERT_EQ(segments->size(), 3u);
  for (int i = 0; i < 3; ++i) {
    EXPECT_THAT(*(*segments)[i], EqualsProto(MakeSegment(i + 1)));
  }
}

TEST(Table, KeepsTheFirstValidSegmentOfAnOrder) {
  Fixture f;
  ASSERT_THAT(f.table.Open(MakeOpen({1}, 0, true)), IsOk());
  v1::Segment stale = MakeSegment(1);
  stale.set_snapshot_version(5);
  v1::Segment second = MakeSegment(1);
  second.set_physics_steps(9);

  EXPECT_EQ(f.Put(1, stale.SerializeAsString()), Response::VERDICT_STALE);
  EXPECT_EQ(f.Put(1, MakeSegmentBytes(1)), Response::VERDICT_ACCEPTED);
  EXPECT_EQ(f.Put(1, second.SerializeAsString()), Response::VERDICT_DUPLICATE);

  const auto segments = f.Collect({1}, absl::InfiniteFuture());
  ASSERT_THAT(segments, IsOk());
  EXPECT_EQ((*segments)[0]->physics_steps(), 0);
}

TEST(Table, KeepsTheFasterOfTwoSegmentsInFlight) {
  Fixture f;
  ASSERT_THAT(f.table.Open(MakeOpen({1}, 0, true)), IsOk());
  const std::string bytes = MakeSegmentBytes(1);
  Table::Admission slow = f.Admit(1, bytes.size());

  EXPECT_EQ(f.Put(1, bytes), Response::VERDICT_ACCEPTED);
  EXPECT_EQ(f.table.Put(std::move(slow.room), bytes).verdict(),
            Response::VERDICT_DUPLICATE);

  EXPECT_EQ(f.table.Status().bytes(), static_cast<int64_t>(bytes.size()));
}

TEST(Table, RefusesWhatNobodyExpects) {
  Fixture f;
  ASSERT_THAT(f.table.Open(MakeOpen({1}, 0, true)), IsOk());

  EXPECT_EQ(f.Put(2, MakeSegmentBytes(2)), Response::VERDICT_UNEXPECTED);
  const auto other =
      f.table.Admit("other", 1, 10, absl::InfiniteFuture(), kNever);
  ASSERT_THAT(other, IsOk());
  EXPECT_EQ(other->refusal->verdict(), Response::VERDICT_UNEXPECTED);
  EXPECT_THAT(other->refusal->detail(), HasSubstr("\"other\""));
}

TEST(Table, RefusesASizeThatNoValidSegmentHas) {
  Fixture f;
  ASSERT_THAT(f.table.Open(MakeOpen({1}, 0, true)), IsOk());

  for (int64_t size : {int64_t{-1}, Most() + 1, int64_t{1} << 62}) {
    const Table::Admission admission = f.Admit(1, size);
    ASSERT_TRUE(admission.refusal.has_value()) << size;
    EXPECT_EQ(admission.refusal->verdict(), Response::VERDICT_MALFORMED);
  }
}

TEST(Table, CallsALateCopyOfATakenSegmentADuplicate) {
  Fixture f;
  ASSERT_THAT(f.table.Open(MakeOpen({1}, 0, true)), IsOk());
  EXPECT_EQ(f.Put(1, MakeSegmentBytes(1)), Response::VERDICT_ACCEPTED);
  f.table.Remove(kRun, {1});

  EXPECT_EQ(f.Put(1, MakeSegmentBytes(1)), Response::VERDICT_DUPLICATE);
  EXPECT_THAT(f.Collect({1}, absl::InfiniteFuture()),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("taken")));
  EXPECT_EQ(f.table.Status().bytes(), 0);
}

TEST(Table, TakesAnOrderAgainThatWasOpenedAgain) {
  Fixture f;
  ASSERT_THAT(f.table.Open(MakeOpen({1}, 0, true)), IsOk());
  EXPECT_EQ(f.Put(1, MakeSegmentBytes(1)), Response::VERDICT_ACCEPTED);
  f.table.Remove(kRun, {1});

  ASSERT_THAT(f.table.Open(MakeOpen({1})), IsOk());

  EXPECT_EQ(f.Put(1, MakeSegmentBytes(1)), Response::VERDICT_ACCEPTED);
}

TEST(Table, SaysWhichSegmentItWaitedFor) {
  Fixture f;
  ASSERT_THAT(f.table.Open(MakeOpen({1, 2}, 0, true)), IsOk());
  EXPECT_EQ(f.Put(1, MakeSegmentBytes(1)), Response::VERDICT_ACCEPTED);

  EXPECT_THAT(f.Collect({1, 2}, absl::InfinitePast()),
              StatusIs(absl::StatusCode::kDeadlineExceeded,
                       HasSubstr("2 orders; the first that is missing is 2")));
  EXPECT_THAT(f.table.Collect(kRun, {1, 2}, absl::InfiniteFuture(),
                              [] { return true; }),
              StatusIs(absl::StatusCode::kCancelled));
}

TEST(Table, WaitsUntilTheLastSegmentArrives) {
  Fixture f;
  ASSERT_THAT(f.table.Open(MakeOpen({1, 2}, 0, true)), IsOk());
  std::jthread writer([&f] {
    EXPECT_EQ(f.Put(2, MakeSegmentBytes(2)), Response::VERDICT_ACCEPTED);
    EXPECT_EQ(f.Put(1, MakeSegmentBytes(1)), Response::VERDICT_ACCEPTED);
  });

  EXPECT_THAT(f.Collect({1, 2}, absl::InfiniteFuture()), IsOk());
}

TEST(Table, MakesWritersWaitWhileItIsFull) {
  // Iteration 1 may need both its segments, so iteration 2 has to wait.
  Fixture f(2 * Most());
  ASSERT_THAT(f.table.Open(MakeOpen({1, 2}, 1, true)), IsOk());
  ASSERT_THAT(f.table.Open(MakeOpen({3}, 2)), IsOk());
  std::jthread writer([&] {
    EXPECT_EQ(f.Put(3, MakeSegmentBytes(3, 2)), Response::VERDICT_ACCEPTED);
  });
  while (f.metrics.writers_waiting.Value() == 0) std::this_thread::yield();

  EXPECT_EQ(f.Put(1, MakeSegmentBytes(1, 1)), Response::VERDICT_ACCEPTED);
  EXPECT_EQ(f.Put(2, MakeSegmentBytes(2, 1)), Response::VERDICT_ACCEPTED);

  writer.join();
  EXPECT_EQ(f.metrics.writers_waiting.Value(), 0);
  EXPECT_GT(f.metrics.blocked_seconds.Value(), 0);
}

TEST(Table, LetsTheOldestIterationInWhateverYoungerOnesHold) {
  // Limit 3 segments: 1 misses two of them, so only one of iteration 2 enters.
  Fixture f(3 * Most());
  ASSERT_THAT(f.table.Open(MakeOpen({1, 2}, 1, true)), IsOk());
  ASSERT_THAT(f.table.Open(MakeOpen({3, 4}, 2)), IsOk());
  Table::Admission younger = f.Admit(3, Most());

  EXPECT_THAT(f.table.Admit(kRun, 4, Most(), absl::InfinitePast(), kNever),
              StatusIs(absl::StatusCode::kDeadlineExceeded,
                       HasSubstr("replay is full")));
  Table::Admission first = f.Admit(1, Most());
  Table::Admission second = f.Admit(2, Most());

  EXPECT_NE(younger.room, nullptr);
  EXPECT_NE(first.room, nullptr);
  EXPECT_NE(second.room, nullptr);
  EXPECT_EQ(f.table.Status().bytes(), f.table.Status().limit_bytes());
}

TEST(Table, GivesRoomBackWhenAWriterGoesAway) {
  Fixture f(Most());
  ASSERT_THAT(f.table.Open(MakeOpen({1}, 1, true)), IsOk());

  f.Admit(1, Most()).room.reset();

  EXPECT_EQ(f.table.Status().bytes(), 0);
  EXPECT_NE(f.Admit(1, Most()).room, nullptr);
}

TEST(Table, RefusesAnIterationThatCouldNeverFit) {
  Fixture f(2 * Most() - 1);

  EXPECT_THAT(f.table.Open(MakeOpen({1, 2}, 1, true)),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       HasSubstr("replay_bytes: the segments of iteration 1")));
  EXPECT_THAT(f.table.Open(MakeOpen({1}, 1)), IsOk());
}

TEST(Table, OpensTheSameOrdersTwiceButNotOthersOfTheSameId) {
  Fixture f;
  ASSERT_THAT(f.table.Open(MakeOpen({1}, 0, true)), IsOk());

  EXPECT_THAT(f.table.Open(MakeOpen({1})), IsOk());
  EXPECT_THAT(f.table.Open(MakeOpen({1}, /*iteration=*/5)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("open already with other content")));
  EXPECT_THAT(f.table.Open(MakeOpen({2, 2})),
              StatusIs(absl::StatusCode::kInvalidArgument));
}

TEST(Table, IsNotTakenFromARunThatTakesSegmentsNow) {
  Fixture f;
  ASSERT_THAT(f.table.Open(MakeOpen({1}, 0, true)), IsOk());
  v1::OpenRequest other = MakeOpen({2}, 0, true);
  other.set_run_id("other");
  EXPECT_THAT(f.Collect({1}, absl::InfinitePast()),
              StatusIs(absl::StatusCode::kDeadlineExceeded));

  EXPECT_THAT(f.table.Open(other),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("open: run: replay serves \"run\"")));
  // Nothing was dropped, and its own learner may start again.
  EXPECT_EQ(f.Put(1, MakeSegmentBytes(1)), Response::VERDICT_ACCEPTED);
  EXPECT_THAT(f.Collect({1}, absl::InfiniteFuture()), IsOk());
  EXPECT_THAT(f.table.Open(MakeOpen({1}, 0, true)), IsOk());

  f.clock.Advance(RunClaim::kActive);
  EXPECT_THAT(f.table.Open(other), IsOk());
}

TEST(Table, IsFreeForAnotherRunOnceTheFirstSaysThatItEnds) {
  Fixture f;
  ASSERT_THAT(f.table.Open(MakeOpen({1}, 0, true)), IsOk());
  EXPECT_THAT(f.Collect({1}, absl::InfinitePast()),
              StatusIs(absl::StatusCode::kDeadlineExceeded));
  v1::OpenRequest end = MakeOpen({});
  end.set_ends(true);
  ASSERT_THAT(f.table.Open(end), IsOk());
  v1::OpenRequest other = MakeOpen({2}, 0, true);
  other.set_run_id("other");

  EXPECT_THAT(f.table.Open(other), IsOk());
}

TEST(Table, ServesOneRunUntilAnotherResetsIt) {
  Fixture f;
  ASSERT_THAT(f.table.Open(MakeOpen({1, 2}, 0, true)), IsOk());
  EXPECT_EQ(f.Put(1, MakeSegmentBytes(1)), Response::VERDICT_ACCEPTED);
  const std::string bytes = MakeSegmentBytes(2);
  Table::Admission late = f.Admit(2, bytes.size());
  v1::OpenRequest other = MakeOpen({2});
  other.set_run_id("other");

  EXPECT_THAT(f.table.Open(other),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("serves \"run\", found \"other\"")));
  other.set_reset(true);
  EXPECT_THAT(f.table.Open(other), IsOk());

  EXPECT_EQ(f.table.Put(std::move(late.room), bytes).verdict(),
            Response::VERDICT_UNEXPECTED);
  EXPECT_EQ(f.table.Status().bytes(), 0);
  EXPECT_THAT(f.Collect({1}, absl::InfiniteFuture()),
              StatusIs(absl::StatusCode::kFailedPrecondition));
}

TEST(Table, RefusesStatesBeyondTheLimitsOfTheRun) {
  Fixture f;
  v1::OpenRequest request = MakeOpen({1}, 0, true);
  v1::StateLimits& limits = *request.mutable_limits();
  EXPECT_THAT(f.table.Open(request),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("open: limits.clips: expected >= 1")));
  limits.add_clips()->set_start_frames(9);
  limits.set_state_size(2);  // MakeSegment's states have one number
  limits.set_joints(1);
  limits.set_max_episode_steps(9);
  ASSERT_THAT(f.table.Open(request), IsOk());
  // They hold for what is opened later.
  ASSERT_THAT(f.table.Open(MakeOpen({2})), IsOk());

  EXPECT_EQ(f.Put(1, MakeSegmentBytes(1)), Response::VERDICT_MALFORMED);
  EXPECT_EQ(f.Put(2, MakeSegmentBytes(2)), Response::VERDICT_MALFORMED);

  // Not beyond a reset.
  ASSERT_THAT(f.table.Open(MakeOpen({1}, 0, true)), IsOk());
  EXPECT_EQ(f.Put(1, MakeSegmentBytes(1)), Response::VERDICT_ACCEPTED);
}

TEST(Table, SaysThatItServesNoRunYet) {
  Fixture f;

  EXPECT_THAT(f.table.Open(MakeOpen({1})),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("run")));
  EXPECT_THAT(f.Collect({1}, absl::InfiniteFuture()),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("run")));
}

TEST(Table, WakesEverybodyWhenItCloses) {
  Fixture f;
  ASSERT_THAT(f.table.Open(MakeOpen({1}, 0, true)), IsOk());
  std::jthread reader([&f] {
    EXPECT_THAT(f.Collect({1}, absl::InfiniteFuture()),
                StatusIs(absl::StatusCode::kUnavailable));
  });

  f.table.Close();
}

TEST(Table, CountsRefusalsByReason) {
  Fixture f;
  ASSERT_THAT(f.table.Open(MakeOpen({1}, 0, true)), IsOk());
  f.Put(1, MakeSegmentBytes(1));
  f.Put(1, MakeSegmentBytes(1));
  f.Put(2, MakeSegmentBytes(2));

  const v1::GetReplayStatusResponse status = f.table.Status();
  EXPECT_EQ(status.accepted(), 1);
  EXPECT_EQ(status.refused().at("VERDICT_DUPLICATE"), 1);
  EXPECT_EQ(status.refused().at("VERDICT_UNEXPECTED"), 1);
  const std::string text = f.registry.Text();
  EXPECT_THAT(text, HasSubstr("sinew_segments_accepted_total 1"));
  EXPECT_THAT(
      text, HasSubstr("sinew_segments_refused_total{reason=\"duplicate\"} 1"));
  EXPECT_THAT(metrics::Lint(text), IsOk());
}

TEST(Table, TakesEachOrderOnceUnderManyWriters) {
  constexpr int kWriters = 4;
  constexpr int kIterations = 20;
  Fixture f(4 * Most());
  ASSERT_THAT(f.table.Open(MakeOpen({}, 0, true)), IsOk());
  for (int64_t k = 0; k < kIterations; ++k) {
    ASSERT_THAT(f.table.Open(MakeOpen({2 * k, 2 * k + 1}, k)), IsOk());
  }
  // Every writer sends everything: three of four are duplicates.
  std::vector<std::jthread> writers;
  for (int w = 0; w < kWriters; ++w) {
    writers.emplace_back([&f] {
      for (int64_t id = 0; id < 2 * kIterations; ++id) {
        f.Put(id, MakeSegmentBytes(id, id / 2));
      }
    });
  }
  for (int64_t k = 0; k < kIterations; ++k) {
    const std::vector<int64_t> ids = {2 * k, 2 * k + 1};
    ASSERT_THAT(f.Collect(ids, absl::InfiniteFuture()), IsOk());
    f.table.Remove(kRun, ids);
  }
  writers.clear();

  EXPECT_EQ(f.table.Status().accepted(), 2 * kIterations);
  EXPECT_EQ(f.table.Status().bytes(), 0);
}

}  // namespace
}  // namespace sinew::replay
