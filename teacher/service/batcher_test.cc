#include "teacher/service/batcher.h"

#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "common/metrics/registry.h"
#include "common/metrics/testing/lint.h"
#include "common/mutex.h"
#include "common/testing/matchers.h"
#include "common/testing/simulated_clock.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::teacher {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::IsOkAndHolds;
using ::sinew::testing::SimulatedClock;
using ::sinew::testing::StatusIs;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// One observation, one action: the target is base + observation. Notes the
// sizes of batches; a gate holds them back; an observation of 666 is an error.
class GatedAnnotator final : public Annotator {
 public:
  GatedAnnotator() {
    description_.set_observation_width(1);
    description_.set_action_width(1);
  }
  const v1::DescribeTeacherResponse& description() const override {
    return description_;
  }
  absl::Span<const double> spread() const override { return {}; }
  absl::Status Annotate(const Rows& rows, absl::Span<double> targets) override {
    MutexLock lock(mu_);
    batches_.push_back(static_cast<int>(targets.size()));
    changed_.NotifyAll();
    while (!open_) changed_.Wait(mu_, {});
    for (size_t i = 0; i < targets.size(); ++i) {
      if (rows.observations[i] == 666) return absl::InternalError("nan");
      targets[i] = rows.bases[i] + rows.observations[i];
    }
    return absl::OkStatus();
  }

  void Shut() {
    MutexLock lock(mu_);
    open_ = false;
  }
  void Open() {
    MutexLock lock(mu_);
    open_ = true;
    changed_.NotifyAll();
  }
  void AwaitBatches(size_t count) {
    MutexLock lock(mu_);
    while (batches_.size() < count) changed_.Wait(mu_, {});
  }
  std::vector<int> batches() {
    MutexLock lock(mu_);
    return batches_;
  }

 private:
  v1::DescribeTeacherResponse description_;
  Mutex mu_;
  CondVar changed_;
  bool open_ SINEW_GUARDED_BY(mu_) = true;
  std::vector<int> batches_ SINEW_GUARDED_BY(mu_);
};

std::string Bytes(const std::vector<double>& values) {
  return std::string(reinterpret_cast<const char*>(values.data()),
                     values.size() * sizeof(double));
}

class BatcherTest : public ::testing::Test {
 protected:
  static constexpr Batcher::Options kOptions = {
      .max_batch_rows = 4, .batch_delay = absl::Seconds(1), .queue_rows = 6};

  // A call of `rows` rows whose targets are 1 + observation, on a thread of
  // its own; its result goes into results_[i].
  void Call(size_t i, int rows, float observation = 2,
            absl::Duration timeout = absl::Hours(1)) {
    threads_.emplace_back([this, i, rows, observation, timeout] {
      const std::vector<float> observations(rows, observation);
      const std::string bases = Bytes(std::vector<double>(rows, 1.0));
      results_[i] = batcher_.Annotate(
          {.rows = rows,
           .observations = {reinterpret_cast<const char*>(observations.data()),
                            observations.size() * sizeof(float)},
           .bases = bases,
           .deadline = clock_.After(timeout),
           .cancelled = [this] { return cancelled_.load(); }});
    });
  }
  void AwaitQueue(double rows) {
    while (metrics_.queue_rows.Value() != rows) std::this_thread::yield();
  }
  void Join() { threads_.clear(); }

  SimulatedClock clock_;
  metrics::Registry registry_{{.role = "teacher", .build = ""}};
  TeacherMetrics metrics_{registry_};
  GatedAnnotator annotator_;
  Batcher batcher_{annotator_, kOptions, clock_, metrics_};
  std::atomic<bool> cancelled_ = false;
  std::vector<absl::StatusOr<std::string>> results_{
      8, absl::StatusOr<std::string>(absl::UnknownError("no answer yet"))};
  std::vector<std::jthread> threads_;
};

TEST_F(BatcherTest, ComputesAFullBatchAtOnce) {
  Call(0, 4);
  Join();

  EXPECT_THAT(results_[0], IsOkAndHolds(Bytes({3, 3, 3, 3})));
}

TEST_F(BatcherTest, WaitsForOthersNoLongerThanItsDelay) {
  Call(0, 1, 2);
  AwaitQueue(1);
  Call(1, 2, 5);
  AwaitQueue(3);
  EXPECT_THAT(annotator_.batches(), ElementsAre());

  clock_.AwaitWaiters(3);
  clock_.Advance(absl::Milliseconds(1001));
  Join();

  EXPECT_THAT(annotator_.batches(), ElementsAre(3));
  EXPECT_THAT(results_[0], IsOkAndHolds(Bytes({3})));
  EXPECT_THAT(results_[1], IsOkAndHolds(Bytes({6, 6})));
}

TEST_F(BatcherTest, KeepsTheRowsOfACallTogether) {
  annotator_.Shut();
  Call(0, 4);
  annotator_.AwaitBatches(1);
  Call(1, 3, 1);
  AwaitQueue(3);
  Call(2, 3, 7);
  AwaitQueue(6);

  // Six rows wait, of which four would fit: the third call stays behind.
  annotator_.Open();
  annotator_.AwaitBatches(2);
  batcher_.Close();  // no delay for the rest
  Join();

  EXPECT_THAT(annotator_.batches(), ElementsAre(4, 3, 3));
  EXPECT_THAT(results_[1], IsOkAndHolds(Bytes({2, 2, 2})));
  EXPECT_THAT(results_[2], IsOkAndHolds(Bytes({8, 8, 8})));
}

TEST_F(BatcherTest, RefusesWhatTheQueueHasNoRoomFor) {
  annotator_.Shut();
  Call(0, 4);
  annotator_.AwaitBatches(1);
  Call(1, 4);
  AwaitQueue(4);
  Call(2, 3);
  threads_.back().join();

  EXPECT_THAT(results_[2],
              StatusIs(absl::StatusCode::kResourceExhausted,
                       HasSubstr("at most 6 rows, found 4 and 3 more")));
  annotator_.Open();
  Join();
  EXPECT_THAT(results_[1], IsOk());
}

TEST_F(BatcherTest, DoesNotComputeWhatHasExpired) {
  annotator_.Shut();
  Call(0, 4);
  annotator_.AwaitBatches(1);
  Call(1, 1, 2, /*timeout=*/absl::Seconds(5));
  AwaitQueue(1);
  // Both calls wait through the clock.
  clock_.AwaitWaiters(2);

  clock_.Advance(absl::Seconds(6));
  AwaitQueue(0);
  annotator_.Open();
  Join();

  EXPECT_THAT(results_[0], IsOk());
  EXPECT_THAT(results_[1], StatusIs(absl::StatusCode::kDeadlineExceeded));
  EXPECT_THAT(annotator_.batches(), ElementsAre(4));
}

TEST_F(BatcherTest, ForgetsACallThatNobodyWaitsFor) {
  Call(0, 1);
  AwaitQueue(1);
  clock_.AwaitWaiters(2);

  cancelled_ = true;
  clock_.Advance(absl::Milliseconds(100));
  Join();

  EXPECT_THAT(results_[0], StatusIs(absl::StatusCode::kCancelled));
  EXPECT_THAT(annotator_.batches(), ElementsAre());
}

TEST_F(BatcherTest, OneCallsErrorIsNotAnothers) {
  Call(0, 2, 2);
  AwaitQueue(2);
  Call(1, 2, 666);  // which fills the batch
  Join();

  EXPECT_THAT(results_[0], IsOkAndHolds(Bytes({3, 3})));
  EXPECT_THAT(results_[1], StatusIs(absl::StatusCode::kInternal));
  EXPECT_THAT(annotator_.batches(), ElementsAre(4, 2, 2));
}

TEST_F(BatcherTest, AnswersWhatWaitsWhenItCloses) {
  Call(0, 1);
  AwaitQueue(1);

  batcher_.Close();
  Join();
  Call(1, 1);
  Join();

  EXPECT_THAT(results_[0], IsOkAndHolds(Bytes({3})));
  EXPECT_THAT(results_[1], StatusIs(absl::StatusCode::kUnavailable,
                                    HasSubstr("shutting down")));
}

TEST_F(BatcherTest, ShowsRowsAndBatches) {
  Call(0, 4);
  Join();
  metrics_.Count(absl::OkStatus(), 0.002);
  metrics_.Count(absl::ResourceExhaustedError("full"), 0.001);
  metrics_.Count(absl::InternalError("nan"), 0.001);

  const std::string text = registry_.Text();

  EXPECT_THAT(metrics::Lint(text), IsOk());
  EXPECT_THAT(text, HasSubstr("sinew_teacher_rows_total 4\n"));
  EXPECT_THAT(text, HasSubstr("sinew_teacher_batch_rows_count 1\n"));
  EXPECT_THAT(text, HasSubstr("sinew_teacher_queue_limit_rows 6\n"));
  EXPECT_THAT(text, HasSubstr("sinew_teacher_queue_rows 0\n"));
  EXPECT_THAT(text,
              HasSubstr("sinew_teacher_requests_total{result=\"full\"} 1\n"));
  EXPECT_THAT(text,
              HasSubstr("sinew_teacher_requests_total{result=\"failed\"} 1\n"));
}

}  // namespace
}  // namespace sinew::teacher
