// What a scraper sees of a run while it trains.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <memory>
#include <string>

#include "absl/time/time.h"
#include "common/files.h"
#include "common/metrics/testing/scrape.h"
#include "common/subprocess.h"
#include "tests/testing/training_rig.h"

namespace sinew::tests {
namespace {

using ::sinew::metrics::testing::Scrape;
using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;

constexpr char kServing[] = "serving metrics";

TEST(MetricsTest, ARunServesThoseOfItsLearnerAndOfEachActor) {
  const TrainingRig rig;
  const std::unique_ptr<Subprocess> train = rig.Start(
      "run",
      rig.Train("run", 0, {"--metrics", "127.0.0.1:0", "--actors", "2"}));
  rig.AwaitRows(*train, "run", 2);

  EXPECT_THAT(Scrape(AddressIn(rig.Output("run"), kServing)),
              AllOf(HasSubstr("200 OK"), HasSubstr("role=\"learner\""),
                    HasSubstr("stage=\"learn\""),
                    ContainsRegex("\nsinew_iterations_total[^\n]* [1-9]"),
                    ContainsRegex("\nsinew_samples_total[^\n]* [1-9]"),
                    HasSubstr("sinew_policy_lag_versions_bucket"),
                    HasSubstr("sinew_orders_outstanding"),
                    HasSubstr("sinew_episode_ends_total{")));
  for (const char* actor : {"actor-0", "actor-1"}) {
    const std::string file =
        JoinPath(rig.Path("run"), std::string("logs/") + actor + ".log");
    std::string address;  // an actor may start later than another's first row
    Await(*train, [&] {
      address = AddressIn(ReadFile(file).value_or(""), kServing);
      return !address.empty();
    });
    EXPECT_THAT(
        Scrape(address),
        AllOf(HasSubstr("200 OK"), HasSubstr("role=\"actor\""),
              HasSubstr("stage=\"simulate\""), HasSubstr("stage=\"infer\""),
              HasSubstr("stage=\"encode\""), HasSubstr("stage=\"send\"")))
        << actor;
  }

  train->Signal(SIGTERM);
  const auto end = train->Wait(absl::Minutes(1));
  EXPECT_TRUE(end.ok() && end->ok()) << rig.Output("run");
}

}  // namespace
}  // namespace sinew::tests
