#include "learner/state/state_saver.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/clock.h"
#include "common/metrics/registry.h"
#include "common/metrics/testing/lint.h"
#include "common/testing/matchers.h"
#include "deploy/checkpoint/client/testing/memory_store.h"
#include "learner/state/testing/make_state.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;
using ::testing::Not;

class StateSaverTest : public ::testing::Test {
 protected:
  SystemClock clock_;
  metrics::Registry registry_{{.role = "learner", .build = ""}};
  SaveMetrics metrics_{registry_};
  checkpoint::MemoryStore store_;
  StateSaver saver_{store_, /*keep=*/2, clock_, metrics_};
};

TEST_F(StateSaverTest, SavesBesideItsCaller) {
  ASSERT_TRUE(saver_.Start(MakeState(7)));
  ASSERT_THAT(saver_.Flush(absl::Seconds(30)), IsOk());

  const auto result = saver_.TakeResult();
  ASSERT_TRUE(result.has_value());
  EXPECT_THAT(result->status, IsOk());
  EXPECT_EQ(result->iteration, 7);
  EXPECT_GT(result->bytes, 6 * 4);
  EXPECT_EQ(store_.GetArtifact("latest")->iteration(), 7);
  EXPECT_FALSE(saver_.TakeResult().has_value());
}

TEST_F(StateSaverTest, HasOneSaveInFlight) {
  store_.Pause();
  ASSERT_TRUE(saver_.Start(MakeState(1)));

  EXPECT_FALSE(saver_.Start(MakeState(2)));
  EXPECT_FALSE(saver_.idle());
  EXPECT_THAT(
      saver_.Flush(absl::ZeroDuration()),
      StatusIs(absl::StatusCode::kDeadlineExceeded, HasSubstr("iteration 1")));

  store_.Resume();
  EXPECT_THAT(saver_.Flush(absl::Seconds(30)), IsOk());
  EXPECT_TRUE(saver_.Start(MakeState(3)));
}

TEST_F(StateSaverTest, FinishesTheSaveInFlightWhenItEnds) {
  checkpoint::MemoryStore store;
  {
    StateSaver saver(store, 2, clock_, metrics_);
    ASSERT_TRUE(saver.Start(MakeState(1)));
  }
  EXPECT_EQ(store.GetArtifact("latest")->iteration(), 1);
}

TEST_F(StateSaverTest, ReportsAndCountsAFailureAndGoesOn) {
  ASSERT_TRUE(saver_.Start(MakeState(1, 1000)));
  ASSERT_THAT(saver_.Flush(absl::Seconds(30)), IsOk());
  store_.LimitBytes(store_.bytes());
  ASSERT_TRUE(saver_.Start(MakeState(2, 1000)));
  ASSERT_THAT(saver_.Flush(absl::Seconds(30)), IsOk());

  EXPECT_THAT(saver_.TakeResult()->status,
              StatusIs(absl::StatusCode::kResourceExhausted));
  EXPECT_EQ(store_.GetArtifact("latest")->iteration(), 1);
  EXPECT_THAT(registry_.Text(), HasSubstr("sinew_checkpoint_failures_total 1"));

  store_.LimitBytes(int64_t{1} << 30);
  ASSERT_TRUE(saver_.Start(MakeState(2, 1000)));
  ASSERT_THAT(saver_.Flush(absl::Seconds(30)), IsOk());
  EXPECT_EQ(store_.GetArtifact("latest")->iteration(), 2);
}

TEST_F(StateSaverTest, ShowsTimeSizeAndLastSuccess) {
  ASSERT_TRUE(saver_.Start(MakeState(1)));
  ASSERT_THAT(saver_.Flush(absl::Seconds(30)), IsOk());

  const std::string text = registry_.Text();

  EXPECT_THAT(metrics::Lint(text), IsOk());
  EXPECT_THAT(text, HasSubstr("sinew_checkpoint_saves_total 1"));
  EXPECT_THAT(text, HasSubstr("sinew_checkpoint_failures_total 0"));
  EXPECT_THAT(text, HasSubstr("sinew_checkpoint_seconds_count 1"));
  EXPECT_THAT(text, Not(HasSubstr("sinew_checkpoint_bytes 0\n")));
  EXPECT_THAT(
      text,
      Not(HasSubstr("sinew_checkpoint_last_success_timestamp_seconds 0\n")));
}

}  // namespace
}  // namespace sinew::learner
