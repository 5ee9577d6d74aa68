// What goes wrong around a run, and what is left of it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <memory>
#include <regex>
#include <string>
#include <vector>

#include "common/files.h"
#include "common/policy/safetensors.h"
#include "common/subprocess.h"
#include "deploy/bundle/bundle.h"
#include "proto/sinew/v1/bundle.pb.h"
#include "sim/world/testing/toy_world.h"
#include "tests/testing/training_rig.h"

namespace sinew::tests {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(RunFaultsTest, NoActorOutlivesItsParent) {
  const TrainingRig rig;
  const auto train = rig.Start("run", rig.Train("run", 0, {"--actors", "2"}));
  rig.AwaitRows(*train, "run", 1);
  const std::vector<pid_t> actors = ChildrenOf(train->pid());
  ASSERT_EQ(actors.size(), 2);

  train->Signal(SIGKILL);
  ASSERT_TRUE(train->Wait(absl::Minutes(1)).ok());

  for (const pid_t actor : actors) {
    AwaitTrue([actor] { return !IsRunning(actor); });
  }
}

TEST(RunFaultsTest, ASignalSavesExportsAndEnds) {
  const TrainingRig rig;
  const auto train = rig.Start("run", rig.Train("run", 0));
  rig.AwaitRows(*train, "run", 3);

  train->Signal(SIGTERM);
  const auto end = train->Wait(absl::Minutes(1));

  ASSERT_TRUE(end.ok() && end->ok()) << rig.Output("run");
  const auto state = rig.StateOf("run");
  EXPECT_EQ(state.counters.iteration(), rig.Rows("run"));
  for (const char* name : {"bundle", "bundle_best"}) {
    const auto bundle = bundle::ReadBundle(JoinPath(rig.Path("run"), name));
    EXPECT_TRUE(bundle.ok()) << bundle.status();
  }
  const auto best =
      bundle::ReadBundle(JoinPath(rig.Path("run"), "bundle_best"));
  ASSERT_TRUE(best.ok()) << best.status();
  EXPECT_GT(best->manifest.metrics().starts(), 0);
  EXPECT_GT(best->manifest.metrics().iteration(), 0);
  EXPECT_LE(best->manifest.metrics().iteration(), state.counters.iteration());
}

TEST(RunFaultsTest, ASecondLearnerOnARunDirectoryIsRefused) {
  const TrainingRig rig;
  const auto train = rig.Start("run", rig.Train("run", 0));
  rig.AwaitRows(*train, "run", 1);

  EXPECT_EQ(rig.Run("second", rig.Train("run", 3)).code, kFailed);

  EXPECT_THAT(rig.Output("second"), HasSubstr(rig.Path("run")));
  train->Signal(SIGTERM);
  const auto end = train->Wait(absl::Minutes(1));
  EXPECT_TRUE(end.ok() && end->ok()) << rig.Output("run");
}

TEST(RunFaultsTest, AnotherRecipeOnAResumedRunIsRefused) {
  const TrainingRig rig;
  rig.MustRun("run", rig.Train("run", 1));

  EXPECT_EQ(
      rig.Run("second", rig.Train("run", 2, {"--set", "ppo.epochs=3"})).code,
      kMisused);

  EXPECT_THAT(rig.Output("second"),
              AllOf(HasSubstr(rig.Path("run")), HasSubstr("ppo.epochs"),
                    HasSubstr("2 -> 3")));
}

TEST(RunFaultsTest, AnotherLibraryOnAResumedRunIsRefusedUntilAskedFor) {
  const TrainingRig rig;
  rig.MustRun("run", rig.Train("run", 3));
  const auto before = rig.StateOf("run");
  const auto inputs = ReadFile(rig.Path("run/inputs/inputs.textproto"));
  ASSERT_TRUE(inputs.ok()) << inputs.status();
  world::testing::LeaveOutOnDisk(2, rig.ToyFile("library"));

  EXPECT_EQ(rig.Run("second", rig.Train("run", 5)).code, kFailed);
  EXPECT_THAT(rig.Output("second"),
              AllOf(HasSubstr(rig.Path("run")), HasSubstr("motion library"),
                    HasSubstr("--migrate-library")));
  // Nothing of the run was touched.
  EXPECT_EQ(rig.Rows("run"), 3);
  const auto inputs_after = ReadFile(rig.Path("run/inputs/inputs.textproto"));
  ASSERT_TRUE(inputs_after.ok()) << inputs_after.status();
  EXPECT_EQ(*inputs_after, *inputs);

  ASSERT_TRUE(before.counters.has_metrics());
  EXPECT_LT(before.counters.metrics().iteration(), 3);
  rig.MustRun("third", rig.Train("run", 4, {"--migrate-library"}));
  // What was found of the clips of before is not said of these.
  const auto migrated = rig.StateOf("run");
  EXPECT_TRUE(!migrated.counters.has_metrics() ||
              migrated.counters.metrics().iteration() >= 3);

  rig.MustRun("on", rig.Train("run", 5));

  const auto after = rig.StateOf("run");
  EXPECT_EQ(after.counters.iteration(), 5);
  EXPECT_EQ(rig.Rows("run"), 5);
  EXPECT_GT(after.counters.samples(), before.counters.samples());
  const auto& old_table = before.counters.curriculum();
  const auto& table = after.counters.curriculum();
  ASSERT_EQ(table.clips_size(), 3);
  EXPECT_TRUE(table.clips(2).left_out());
  EXPECT_EQ(table.clips(2).sha256(), old_table.clips(2).sha256());
  EXPECT_GE(table.clips(0).evaluations(), old_table.clips(0).evaluations());
  for (int b = 0; b < table.bins_size(); ++b) {
    EXPECT_LT(table.bins(b).clip(), 2);
    EXPECT_GE(table.bins(b).visits(), old_table.bins(b).visits());
  }
  // From here on it is the run's library.
  rig.MustRun("further", rig.Train("run", 6));
  // But what it was trained on before is not called left out.
  const auto bundle = bundle::ReadBundle(rig.Path("run/bundle"));
  ASSERT_TRUE(bundle.ok()) << bundle.status();
  const v1::BundleProvenance& provenance = bundle->manifest.provenance();
  ASSERT_EQ(provenance.clip_uses_size(), 3);
  EXPECT_EQ(provenance.clip_uses(1), v1::CLIP_USE_TRAINED_ON);
  EXPECT_EQ(provenance.clip_uses(2), v1::CLIP_USE_SOURCE_TRAINED_ON);
}

// Flips the last bit of the fallen states in a store's folder.
void DamageFallenStates(const std::string& store) {
  const std::string blobs = JoinPath(store, "blobs");
  const auto names = ListDirectory(blobs);
  ASSERT_TRUE(names.ok()) << names.status();
  int damaged = 0;
  for (const std::string& name : *names) {
    auto bytes = ReadFile(JoinPath(blobs, name));
    ASSERT_TRUE(bytes.ok()) << bytes.status();
    if (bytes->find("sinew.fallen_states") == std::string::npos) continue;
    bytes->back() ^= 1;
    ASSERT_TRUE(WriteFileAtomically(JoinPath(blobs, name), *bytes).ok());
    ++damaged;
  }
  ASSERT_EQ(damaged, 1);
}

TEST(RunFaultsTest, DamagedFallenStatesOfAResumedRunAreMadeAnew) {
  const TrainingRig rig;
  const std::vector<std::string> recovery = {
      "--set", "task.recovery.fallen_share=0.3",
      "--set", "task.recovery.fallen_states=4",
      "--set", "task.recovery.steps=6"};
  const std::string mark = "fallen states are made anew";
  rig.MustRun("straight", rig.Train("straight", 4, recovery));
  rig.MustRun("first", rig.Train("run", 2, recovery));
  rig.MustRun("second", rig.Train("run", 3, recovery));
  EXPECT_THAT(*ReadFile(rig.Path("run/log.jsonl")), Not(HasSubstr(mark)));
  DamageFallenStates(rig.Path("run/checkpoints"));

  rig.MustRun("third", rig.Train("run", 4, recovery));

  EXPECT_THAT(*ReadFile(rig.Path("run/log.jsonl")), HasSubstr(mark));
  EXPECT_EQ(rig.FingerprintOf("run"), rig.FingerprintOf("straight"));
}

TEST(RunFaultsTest, APortInUseIsNamed) {
  const TrainingRig rig;
  const auto replay =
      rig.Start("replay", {"replay", "--listen", "127.0.0.1:0"});
  const std::string address = rig.AwaitAddress(*replay, "replay");

  EXPECT_EQ(
      rig.Run("learner", rig.Learner("run", 1, {"--listen", address})).code,
      kFailed);

  EXPECT_THAT(rig.Output("learner"), HasSubstr(address));
}

TEST(RunFaultsTest, ActorsStayForTheRunThatWasStoppedAndFollowItToItsReplay) {
  const TrainingRig rig;
  const auto replay = [&rig](const std::string& name) {
    return rig.Start(name, {"replay", "--listen", "127.0.0.1:0"});
  };
  const auto first_replay = replay("replay1");
  const auto second_replay = replay("replay2");
  const auto first = rig.Start(
      "learner1", rig.Learner("run", 0,
                              {"--listen", "127.0.0.1:0", "--replay",
                               rig.AwaitAddress(*first_replay, "replay1")}));
  const std::string address = rig.AwaitAddress(*first, "learner1");
  const auto actor =
      rig.Start("actor", {"actor", "--learner", address, "--cache",
                          rig.Path("cache"), "--threads", "1"});
  rig.AwaitRows(*first, "run", 2);

  first->Signal(SIGTERM);
  const auto stopped = first->Wait(absl::Minutes(1));
  ASSERT_TRUE(stopped.ok() && stopped->ok()) << rig.Output("learner1");
  const int end = rig.Rows("run") + 2;
  const auto second = rig.Start(
      "learner2", rig.Learner("run", end,
                              {"--listen", address, "--replay",
                               rig.AwaitAddress(*second_replay, "replay2")}));

  const auto done = second->Wait(absl::Minutes(2));
  ASSERT_TRUE(done.ok() && done->ok())
      << rig.Output("learner2") << rig.Output("actor");
  const auto gone = actor->Wait(absl::Minutes(1));
  ASSERT_TRUE(gone.ok() && gone->ok()) << rig.Output("actor");
  EXPECT_THAT(rig.Output("actor"),
              AllOf(HasSubstr("the learner is going away"),
                    HasSubstr("the learner has no more orders")));
}

TEST(RunFaultsTest, AReplayHasOneRunAtATimeAndTheNextOnceThatHasEnded) {
  const TrainingRig rig;
  const auto replay =
      rig.Start("replay", {"replay", "--listen", "127.0.0.1:0"});
  const std::string address = rig.AwaitAddress(*replay, "replay");
  const auto learner = [&](const std::string& run, int iterations,
                           const std::string& seed) {
    return rig.Learner(
        run, iterations,
        {"--listen", "127.0.0.1:0", "--replay", address, "--seed", seed});
  };
  const auto actor_of = [&](Subprocess& process, const std::string& run) {
    return rig.Start(run + "-actor",
                     {"actor", "--learner", rig.AwaitAddress(process, run),
                      "--cache", rig.Path(run + "-cache"), "--threads", "1"});
  };
  const auto first = rig.Start("first", learner("first", 2, "1"));
  const auto first_actor = actor_of(*first, "first");
  const auto first_end = first->Wait(absl::Minutes(2));
  ASSERT_TRUE(first_end.ok() && first_end->ok()) << rig.Output("first");

  const auto second = rig.Start("second", learner("second", 0, "2"));
  const auto second_actor = actor_of(*second, "second");
  rig.AwaitRows(*second, "second", 1);
  EXPECT_EQ(rig.Run("third", learner("third", 0, "3")).code, kFailed);

  EXPECT_THAT(rig.Output("third"), HasSubstr("run: replay serves"));
  rig.AwaitRows(*second, "second", rig.Rows("second") + 2);
  EXPECT_THAT(rig.Output("replay"),
              HasSubstr("another run's learner takes replay over"));
  for (Subprocess* process : {second.get(), second_actor.get()}) {
    process->Signal(SIGTERM);
    EXPECT_TRUE(process->Wait(absl::Minutes(1)).ok());
  }
}

TEST(RunFaultsTest, ALearnerStopsSoonThoughReplayIsAway) {
  const TrainingRig rig;
  const auto replay =
      rig.Start("replay", {"replay", "--listen", "127.0.0.1:0"});
  const auto learner =
      rig.Start("learner", rig.Learner("run", 0,
                                       {"--listen", "127.0.0.1:0", "--replay",
                                        rig.AwaitAddress(*replay, "replay")}));
  const auto actor = rig.Start(
      "actor", {"actor", "--learner", rig.AwaitAddress(*learner, "learner"),
                "--cache", rig.Path("cache"), "--threads", "1"});
  rig.AwaitRows(*learner, "run", 2);
  replay->Signal(SIGKILL);
  ASSERT_TRUE(replay->Wait(absl::Minutes(1)).ok());
  Await(*learner, [&rig] {
    return rig.Output("learner").find("replay is away") != std::string::npos;
  });

  learner->Signal(SIGTERM);

  // Calls to replay would wait for half a minute each.
  const auto end = learner->Wait(absl::Seconds(40));
  ASSERT_TRUE(end.ok() && end->ok()) << rig.Output("learner");
  EXPECT_EQ(rig.StateOf("run").counters.iteration(), rig.Rows("run"));
  EXPECT_TRUE(IsRunning(actor->pid()));
  actor->Signal(SIGTERM);
  EXPECT_TRUE(actor->Wait(absl::Minutes(1)).ok());
}

TEST(RunFaultsTest, AnActorThatIsKilledIsReplaced) {
  const TrainingRig rig;
  rig.MustRun("straight", rig.Train("straight", 6));
  const auto train = rig.Start("run", rig.Train("run", 6));
  rig.AwaitRows(*train, "run", 1);
  for (const pid_t actor : ChildrenOf(train->pid())) kill(actor, SIGKILL);

  const auto end = train->Wait(absl::Minutes(2));

  ASSERT_TRUE(end.ok() && end->ok()) << rig.Output("run");
  EXPECT_EQ(rig.FingerprintOf("run"), rig.FingerprintOf("straight"));
}

TEST(RunFaultsTest, ASaveThatFailsIsCountedAndEndsNothing) {
  const TrainingRig rig;
  // Without evaluations: a best policy that cannot be kept would count as well.
  const auto train =
      rig.Start("run", rig.Train("run", 0, {"--set", "evaluation.interval=0"}));
  rig.AwaitRows(*train, "run", 2);
  const std::string blobs = rig.Path("run") + "/checkpoints/blobs";
  std::filesystem::rename(blobs, blobs + ".away");

  const std::regex counted("\"save_failures\":[1-9]");
  Await(*train, [&] {
    const auto text = ReadFile(rig.Path("run") + "/metrics.jsonl");
    return text.ok() && std::regex_search(*text, counted);
  });
  std::filesystem::rename(blobs + ".away", blobs);
  const int rows = rig.Rows("run");
  rig.AwaitRows(*train, "run", rows + 2);
  train->Signal(SIGTERM);
  const auto end = train->Wait(absl::Minutes(1));

  ASSERT_TRUE(end.ok() && end->ok()) << rig.Output("run");
  EXPECT_THAT(rig.Output("run"), HasSubstr("cannot save the training state"));
  EXPECT_EQ(rig.StateOf("run").counters.iteration(), rig.Rows("run"));
}

TEST(RunFaultsTest, ANewRunBeginsWithTheWeightsOfABundle) {
  const TrainingRig rig;
  rig.MustRun("first", rig.Train("first", 4));
  const std::string init = rig.Path("first") + "/bundle";
  const std::vector<std::string> frozen = {
      "--set", "ppo.policy_learning_rate=1e-12", "--seed", "9"};
  std::vector<std::string> with_init = frozen;
  with_init.insert(with_init.end(), {"--init", init});

  rig.MustRun("fresh", rig.Train("fresh", 1, frozen));
  rig.MustRun("init", rig.Train("init", 1, with_init));

  const auto weights = [](const std::string& folder) {
    const auto bundle = bundle::ReadBundle(folder);
    EXPECT_TRUE(bundle.ok()) << bundle.status();
    const HostTensor& tensor = bundle->weights.at("policy/mean/weight");
    return std::vector<float>(tensor.float32().begin(), tensor.float32().end());
  };
  const auto expected = weights(init);
  const auto found = weights(rig.Path("init") + "/bundle");
  const auto fresh = weights(rig.Path("fresh") + "/bundle");
  ASSERT_EQ(found.size(), expected.size());
  double worst = 0;
  double fresh_worst = 0;
  for (size_t i = 0; i < expected.size(); ++i) {
    worst = std::max<double>(worst, std::abs(found[i] - expected[i]));
    fresh_worst =
        std::max<double>(fresh_worst, std::abs(fresh[i] - expected[i]));
  }
  // Adam's steps are as long as the learning rate.
  EXPECT_LT(worst, 1e-6);
  EXPECT_GT(fresh_worst, 1e-2);
}

}  // namespace
}  // namespace sinew::tests
