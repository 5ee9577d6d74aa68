#include "common/metrics/metrics_server.h"

#include <string>

#include "absl/status/status.h"
#include "common/metrics/testing/scrape.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::metrics {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

TEST(MetricsServer, AnswersScrapesOnAPortOfItsChoice) {
  Registry registry({.role = "replay", .build = "abc"});
  registry.AddCounter("sinew_things_total", "Things.").Increment(7);
  const auto server = MetricsServer::Start("127.0.0.1:0", registry);
  ASSERT_THAT(server, IsOk());

  const std::string answer = testing::Scrape((*server)->address());

  EXPECT_THAT(answer, HasSubstr("200 OK"));
  EXPECT_THAT(answer, HasSubstr("sinew_things_total 7"));
  EXPECT_THAT(answer, HasSubstr("process_cpu_seconds_total"));
}

TEST(MetricsServer, NamesAPortThatIsInUse) {
  Registry registry({.role = "replay", .build = ""});
  const auto first = MetricsServer::Start("127.0.0.1:0", registry);
  ASSERT_THAT(first, IsOk());

  EXPECT_THAT(MetricsServer::Start((*first)->address(), registry),
              StatusIs(absl::StatusCode::kAlreadyExists,
                       HasSubstr((*first)->address())));
}

TEST(MetricsServer, RefusesWhatIsNoTcpAddress) {
  Registry registry({.role = "replay", .build = ""});

  EXPECT_THAT(MetricsServer::Start("unix:/tmp/x", registry),
              StatusIs(absl::StatusCode::kInvalidArgument));
}

}  // namespace
}  // namespace sinew::metrics
