// However a run is carried out, it ends with the same bits.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "proto/sinew/v1/bundle.pb.h"
#include "tests/testing/training_rig.h"

namespace sinew::tests {
namespace {

using ::sinew::testing::IsOk;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kIterations = 6;

// One process and one actor, straight through.
std::string Expected(const TrainingRig& rig) {
  rig.MustRun("straight", rig.Train("straight", kIterations));
  EXPECT_EQ(rig.Rows("straight"), kIterations);
  return rig.FingerprintOf("straight");
}

TEST(EqualityTest, ARunThatStoppedAndWentOnEqualsOneThatDidNot) {
  const TrainingRig rig;
  const std::string expected = Expected(rig);

  rig.MustRun("first", rig.Train("halves", kIterations / 2));
  rig.MustRun("second", rig.Train("halves", kIterations));

  EXPECT_EQ(rig.FingerprintOf("halves"), expected);
  EXPECT_EQ(rig.Rows("halves"), kIterations);
}

// The rig evaluates every second iteration, which takes effect after the next
// one: so the evaluation of 2 is the latest one after 3 and after 4.
TEST(EqualityTest, TheLastBundleSaysTheLatestMetricsWhicheverSessionMadeThem) {
  const TrainingRig rig;
  rig.MustRun("straight", rig.Train("straight", 4));
  rig.MustRun("first", rig.Train("halves", 3));
  rig.MustRun("second", rig.Train("halves", 4));

  const auto metrics = [&rig](const std::string& run) {
    const auto bundle = bundle::ReadBundle(JoinPath(rig.Path(run), "bundle"));
    EXPECT_THAT(bundle, IsOk());
    return bundle.ok() ? bundle->manifest.metrics() : v1::BundleMetrics();
  };
  EXPECT_EQ(metrics("straight").iteration(), 2);
  EXPECT_GT(metrics("straight").starts(), 0);
  EXPECT_EQ(metrics("halves").SerializeAsString(),
            metrics("straight").SerializeAsString());
}

TEST(EqualityTest, AKilledRunThatWentOnEqualsOneThatWasNotKilled) {
  const TrainingRig rig;
  std::mt19937 random(7);

  for (int kill = 0; kill < 2; ++kill) {
    const int rows = rig.Rows("killed");
    // Somewhere within an iteration or a save.
    rig.KillAfter("killed", rows + 1 + static_cast<int>(random() % 3),
                  absl::Milliseconds(random() % 50), rig.Train("killed", 0));
  }
  // Wherever the kills found it, the end is beyond: rows are written before
  // states.
  const int end = rig.Rows("killed") + 3;
  rig.MustRun("resumed", rig.Train("killed", end));
  rig.MustRun("straight", rig.Train("straight", end));

  EXPECT_EQ(rig.FingerprintOf("killed"), rig.FingerprintOf("straight"));
  EXPECT_EQ(rig.Rows("killed"), end);
}

TEST(EqualityTest, ThreeActorsEqualOne) {
  const TrainingRig rig;
  const std::string expected = Expected(rig);

  rig.MustRun("three", rig.Train("three", kIterations,
                                 {"--actors", "3", "--threads", "3"}));

  EXPECT_EQ(rig.FingerprintOf("three"), expected);
}

TEST(EqualityTest, FiveProcessesOverTcpEqualOneProcess) {
  const TrainingRig rig;
  const std::string expected = Expected(rig);

  const auto replay =
      rig.Start("replay", {"replay", "--listen", "127.0.0.1:0"});
  const auto checkpoint =
      rig.Start("checkpoint", {"checkpoint", "serve", "--folder",
                               rig.Path("store"), "--listen", "127.0.0.1:0"});
  const auto learner = rig.Start(
      "learner",
      rig.Learner("apart", kIterations,
                  {"--listen", "127.0.0.1:0", "--replay",
                   rig.AwaitAddress(*replay, "replay"), "--checkpoint",
                   rig.AwaitAddress(*checkpoint, "checkpoint")}));
  const std::string address = rig.AwaitAddress(*learner, "learner");
  const auto actor = [&](const std::string& name) {
    return rig.Start(name, {"actor", "--learner", address, "--cache",
                            rig.Path(name + "-cache"), "--threads", "1",
                            "--reconnect-seconds", "20"});
  };
  const auto first = actor("actor1");
  const auto second = actor("actor2");
  const auto status = learner->Wait(absl::Minutes(2));

  ASSERT_TRUE(status.ok() && status->ok())
      << rig.Output("learner") << rig.Output("actor1");
  EXPECT_EQ(Fingerprint(LatestState(rig.Path("store"))), expected);
  // An actor goes when the learner does; one that was so slow to start that it
  // never met the learner says so.
  int served = 0;
  for (const auto& [name, process] :
       {std::pair("actor1", first.get()), std::pair("actor2", second.get())}) {
    const auto end = process->Wait(absl::Minutes(1));
    ASSERT_THAT(end, IsOk()) << rig.Output(name);
    served += end->ok();
    if (end->ok()) continue;
    EXPECT_THAT(rig.Output(name), AllOf(HasSubstr("no learner at"),
                                        Not(HasSubstr("registered"))));
  }
  EXPECT_GT(served, 0);
}

}  // namespace
}  // namespace sinew::tests
