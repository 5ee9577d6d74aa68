#include "common/rpc/retry.h"

#include <cstdint>
#include <stop_token>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::rpc {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

TEST(Backoff, GrowsToItsLongestAndStartsAgainAfterASuccess) {
  Backoff backoff({.initial = absl::Seconds(1),
                   .longest = absl::Seconds(4),
                   .factor = 2,
                   .jitter = 0},
                  /*seed=*/1);

  EXPECT_EQ(backoff.Next(), absl::Seconds(1));
  EXPECT_EQ(backoff.Next(), absl::Seconds(2));
  EXPECT_EQ(backoff.Next(), absl::Seconds(4));
  EXPECT_EQ(backoff.Next(), absl::Seconds(4));
  backoff.Reset();
  EXPECT_EQ(backoff.Next(), absl::Seconds(1));
}

TEST(Backoff, SpreadsCallersWithinItsJitter) {
  Backoff one({.initial = absl::Seconds(1), .factor = 1, .jitter = 0.2}, 1);
  Backoff two({.initial = absl::Seconds(1), .factor = 1, .jitter = 0.2}, 2);

  bool differ = false;
  for (int i = 0; i < 20; ++i) {
    const absl::Duration wait = one.Next();
    EXPECT_GE(wait, absl::Milliseconds(800));
    EXPECT_LE(wait, absl::Milliseconds(1200));
    differ |= wait != two.Next();
  }
  EXPECT_TRUE(differ);
}

TEST(FreshSeed, IsAnotherOneForEveryCaller) {
  const uint64_t first = FreshSeed();

  EXPECT_NE(FreshSeed(), first);
}

TEST(WaitFor, EndsAtOnceWhenStopped) {
  std::stop_source stop;
  stop.request_stop();

  EXPECT_FALSE(WaitFor(absl::Hours(1), stop.get_token()));
}

TEST(Retry, TriesAgainUntilAPeerAnswers) {
  int attempts = 0;
  int waits = 0;

  const absl::Status status = Retry(
      Backoff({}, /*seed=*/1), /*max_attempts=*/5,
      [&](absl::Duration) { return ++waits > 0; },
      [&] {
        return ++attempts < 3 ? absl::UnavailableError("away")
                              : absl::OkStatus();
      });

  EXPECT_THAT(status, IsOk());
  EXPECT_EQ(attempts, 3);
  EXPECT_EQ(waits, 2);
}

TEST(Retry, GivesUpAfterItsAttempts) {
  int attempts = 0;

  const absl::Status status = Retry(
      Backoff({}, /*seed=*/1), /*max_attempts=*/3,
      [](absl::Duration) { return true; },
      [&] {
        ++attempts;
        return absl::UnavailableError("away");
      });

  EXPECT_THAT(status, StatusIs(absl::StatusCode::kUnavailable, "away"));
  EXPECT_EQ(attempts, 3);
}

TEST(Retry, NeverRepeatsARequestThatWasRefused) {
  int attempts = 0;

  const absl::Status status = Retry(
      Backoff({}, /*seed=*/1), /*max_attempts=*/3,
      [](absl::Duration) { return true; },
      [&] {
        ++attempts;
        return absl::NotFoundError("no");
      });

  EXPECT_THAT(status, StatusIs(absl::StatusCode::kNotFound));
  EXPECT_EQ(attempts, 1);
}

TEST(Retry, EndsWithTheLastErrorWhenStopped) {
  const absl::Status status = Retry(
      Backoff({}, /*seed=*/1), /*max_attempts=*/3,
      [](absl::Duration) { return false; },
      [] { return absl::UnavailableError("away"); });

  EXPECT_THAT(status,
              StatusIs(absl::StatusCode::kCancelled, HasSubstr("away")));
}

}  // namespace
}  // namespace sinew::rpc
