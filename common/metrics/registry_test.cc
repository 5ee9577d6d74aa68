#include "common/metrics/registry.h"

#include <string>

#include "common/metrics/learner_metrics.h"
#include "common/metrics/testing/lint.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::metrics {
namespace {

using ::sinew::testing::IsOk;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(Registry, SaysWhichBuildRunsAsWhat) {
  Registry registry({.role = "actor", .build = "abc"});

  EXPECT_THAT(registry.Text(),
              HasSubstr("sinew_build_info{build=\"abc\",role=\"actor\"} 1"));
}

TEST(Registry, ShowsWhatMoved) {
  Registry registry({.role = "actor", .build = ""});
  Counter& one =
      registry.AddCounter("sinew_things_total", "Things.", {{"kind", "one"}});
  registry.AddCounter("sinew_things_total", "Things.", {{"kind", "two"}});
  registry.AddHistogram("sinew_lag_seconds", "Lag.", {1, 2}).Observe(1.5);

  one.Increment(3);

  const std::string text = registry.Text();
  EXPECT_THAT(text, HasSubstr("sinew_things_total{kind=\"one\"} 3"));
  EXPECT_THAT(text, HasSubstr("sinew_things_total{kind=\"two\"} 0"));
  EXPECT_THAT(text, HasSubstr("sinew_lag_seconds_bucket{le=\"2\"} 1"));
}

TEST(Registry, IsBroughtUpToDateBeforeItIsRead) {
  Registry registry({.role = "actor", .build = ""});
  Gauge& gauge = registry.AddGauge("sinew_things", "Things there are.");
  int things = 3;
  registry.BeforeScrape([&] { gauge.Set(things); });

  EXPECT_THAT(registry.Text(), HasSubstr("sinew_things 3\n"));
  things = 4;
  EXPECT_THAT(registry.Text(), HasSubstr("sinew_things 4\n"));
}

TEST(Registry, KnowsItsProcess) {
  Registry registry({.role = "actor", .build = ""});

  const std::string text = registry.Text();

  for (const std::string name :
       {"process_resident_memory_bytes", "process_virtual_memory_bytes",
        "process_open_fds", "process_max_fds", "process_threads",
        "process_start_time_seconds"}) {
    EXPECT_THAT(text, HasSubstr("\n" + name + " ")) << name;
    EXPECT_THAT(text, Not(HasSubstr("\n" + name + " 0\n"))) << name;
  }
  // May still be 0: its unit is a clock tick.
  EXPECT_THAT(text, HasSubstr("\nprocess_cpu_seconds_total "));
}

TEST(LearnerMetrics, KeepToPrometheusRules) {
  Registry registry({.role = "learner", .build = "abc"});
  LearnerMetrics metrics(registry);
  metrics.stage_seconds.Add("learn", 1.5);
  metrics.policy_lag.Observe(1);

  const std::string text = registry.Text();

  EXPECT_THAT(Lint(text), IsOk());
  EXPECT_THAT(text,
              HasSubstr("sinew_stage_seconds_total{stage=\"learn\"} 1.5"));
}

}  // namespace
}  // namespace sinew::metrics
