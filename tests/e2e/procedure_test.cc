// PHC+ by the real program: however it is cut up, it ends with the same bits.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/types.h>

#include <csignal>
#include <cstddef>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "common/files.h"
#include "common/policy/safetensors.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "learner/trainer/trainer.h"
#include "tests/testing/training_rig.h"
#include "tools/training/procedure_record.h"

namespace sinew::tests {
namespace {

using ::sinew::testing::IsOk;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

// Evaluations ask for more than anybody can do, so that there is a hard set
// whatever is learned, and primitives are grown until there are two.
const std::vector<std::string> kStages = {
    "stages/00_primitive_0", "stages/01_primitive_0_hard",
    "stages/02_primitive_1", "stages/03_primitive_1_hard",
    "stages/04_recovery",    "stages/05_composer"};

// Iterations of 64 samples.
constexpr int kFull = 4, kOthers = 2, kLong = 8, kLongest = 16;

// `set`: more assignments, which win.
TrainingRig::Arguments Train(const TrainingRig& rig, const std::string& run,
                             int iterations = 0,
                             const std::vector<std::string>& set = {}) {
  TrainingRig::Arguments more;
  for (const std::string& assignment :
       {absl::StrCat("procedure.full_samples=", 64 * kFull),
        absl::StrCat("procedure.hard_samples=", 64 * kOthers),
        absl::StrCat("procedure.recovery_samples=", 64 * kOthers),
        absl::StrCat("procedure.composer_samples=", 64 * kOthers),
        std::string("procedure.composer_hidden=[8]"),
        std::string("procedure.learnable_share=0"),
        std::string("task.recovery.far_share=0.5"),
        std::string("plateau.evaluations=50"),
        std::string("evaluation.max_mean_body_distance=1e-6")}) {
    more.insert(more.end(), {"--set", assignment});
  }
  for (const std::string& assignment : set) {
    more.insert(more.end(), {"--set", assignment});
  }
  return rig.Train(run, iterations, more);
}

// Every stage long enough to be hit before its end.
std::vector<std::string> LongStages() {
  std::vector<std::string> set;
  for (const char* stage : {"full", "hard", "recovery", "composer"}) {
    set.push_back(
        absl::StrCat("procedure.", stage, "_samples=", 64 * kLongest));
  }
  return set;
}

// Of what a procedure leaves: the state of each stage, and the weights that it
// came to.
std::vector<std::string> Fingerprints(
    const TrainingRig& rig, const std::string& run,
    const std::vector<std::string>& stages = kStages) {
  std::vector<std::string> all;
  for (const std::string& stage : stages) {
    all.push_back(rig.FingerprintOf(JoinPath(run, stage)));
  }
  const auto bundle = bundle::ReadBundle(JoinPath(rig.Path(run), "bundle"));
  EXPECT_THAT(bundle, IsOk());
  all.push_back(bundle.ok() ? SerializeSafetensors(bundle->weights) : run);
  return all;
}

// Clips that a stage's starts are drawn from.
std::set<int> ClipsDrawn(const TrainingRig& rig, const std::string& run,
                         const std::string& stage) {
  std::set<int> drawn;
  const learner::Trainer::State state = rig.StateOf(JoinPath(run, stage));
  for (const auto& bin : state.counters.curriculum().bins()) {
    if (bin.probability() > 0) drawn.insert(bin.clip());
  }
  return drawn;
}

TEST(ProcedureTest, EndsWithTheSameBitsHoweverItIsStoppedOrKilled) {
  const TrainingRig rig;
  rig.MustRun("straight", Train(rig, "straight"));
  const auto expected = Fingerprints(rig, "straight");
  const auto record = ReadFile(rig.Path("straight/procedure.json"));
  ASSERT_THAT(record, IsOk());
  EXPECT_THAT(*record, AllOf(HasSubstr("max_primitives = 2 is reached"),
                             HasSubstr("a composer over 3 primitives"),
                             HasSubstr("that of composer")));

  // Between two stages, then within one.
  rig.MustRun("first", Train(rig, "cut", kFull));
  EXPECT_FALSE(FileExists(rig.Path("cut/bundle")));
  EXPECT_THAT(rig.Output("first"), HasSubstr("give more --iterations"));
  rig.MustRun("second", Train(rig, "cut", kFull + kOthers + 1));
  rig.MustRun("last", Train(rig, "cut"));

  EXPECT_EQ(Fingerprints(rig, "cut"), expected);
}

TEST(ProcedureTest, EndsWithTheSameBitsIfItIsKilledInEveryStage) {
  const TrainingRig rig;
  const std::vector<std::string> longer = LongStages();
  rig.MustRun("straight", Train(rig, "straight", 0, longer));

  std::mt19937 random(3);
  for (const std::string& stage : kStages) {
    const std::string run = JoinPath("cut", stage);
    rig.KillAfter(run, 1, absl::Milliseconds(random() % 20),
                  Train(rig, "cut", 0, longer));
    // Within the stage, not after it.
    ASSERT_LT(rig.Rows(run), kLongest) << stage;
  }
  rig.MustRun("last", Train(rig, "cut", 0, longer));

  EXPECT_EQ(Fingerprints(rig, "cut"), Fingerprints(rig, "straight"));
}

TEST(ProcedureTest, EndsWithTheSameBitsIfItsActorsAreKilledInEveryStage) {
  const TrainingRig rig;
  const std::vector<std::string> longer = LongStages();
  rig.MustRun("straight", Train(rig, "straight", 0, longer));

  const auto process = rig.Start("cut", Train(rig, "cut", 0, longer));
  for (const std::string& stage : kStages) {
    const std::string run = JoinPath("cut", stage);
    rig.AwaitRows(*process, run, 1);
    const std::vector<pid_t> actors = ChildrenOf(process->pid());
    for (const pid_t actor : actors) kill(actor, SIGKILL);
    // The stage has something left to ask of them.
    ASSERT_LT(rig.Rows(run), kLongest) << stage;
    ASSERT_THAT(actors, Not(IsEmpty())) << stage;
  }
  const auto end = process->Wait(absl::Minutes(1));

  ASSERT_TRUE(end.ok() && end->ok()) << rig.Output("cut");
  EXPECT_EQ(Fingerprints(rig, "cut"), Fingerprints(rig, "straight"));
}

TEST(ProcedureTest, LearnsOnThePartOfTheClipsThatIsHard) {
  const TrainingRig rig;
  // Any policy stands through "sway" and half a second of "turn"; none flies
  // like "tumble". So there is nothing to grow another primitive for.
  const std::vector<std::string> feasible = {
      "evaluation.max_mean_body_distance=0.4", "procedure.learnable_share=1"};
  const std::vector<std::string> stages = {
      "stages/00_primitive_0", "stages/01_primitive_0_hard",
      "stages/02_recovery", "stages/03_composer"};
  rig.MustRun("straight", Train(rig, "straight", 0, feasible));

  const auto record = tools::ParseProcedure(
      ReadFile(rig.Path("straight/procedure.json")).value_or(""),
      "procedure.json");
  ASSERT_THAT(record, IsOk());
  ASSERT_EQ(record->stages.size(), stages.size());
  EXPECT_THAT(record->stages[1].decision.next->clips, ElementsAre("tumble"));
  ASSERT_TRUE(record->end);
  EXPECT_THAT(record->end->evidence.hard, ElementsAre("tumble"));
  for (size_t i = 0; i < stages.size(); ++i) {
    EXPECT_EQ(record->stages[i].directory, stages[i]);
    const std::set<int> all = {0, 1, 2}, hard = {2};
    EXPECT_EQ(ClipsDrawn(rig, "straight", stages[i]), i == 1 ? hard : all)
        << stages[i];
  }

  // In the midst of the stage on the hard set.
  rig.MustRun("first", Train(rig, "cut", kFull + 1, feasible));
  rig.MustRun("last", Train(rig, "cut", 0, feasible));

  EXPECT_EQ(Fingerprints(rig, "cut", stages),
            Fingerprints(rig, "straight", stages));
}

TEST(ProcedureTest, TrainsASinglePrimitiveOnBesideIt) {
  const TrainingRig rig;
  const std::vector<std::string> compared = {
      "procedure.compare_single=true", "procedure.max_primitives=1",
      "procedure.recovery_samples=0", "procedure.composer_samples=0"};
  const std::vector<std::string> stages = {"stages/00_primitive_0",
                                           "stages/01_primitive_0_hard",
                                           "stages/02_single"};
  rig.MustRun("straight", Train(rig, "straight", 0, compared));

  const auto record = tools::ParseProcedure(
      ReadFile(rig.Path("straight/procedure.json")).value_or(""),
      "procedure.json");
  ASSERT_THAT(record, IsOk());
  ASSERT_EQ(record->Finished().size(), stages.size());
  // As many as the hard stage, the only one after the first.
  EXPECT_EQ(record->Finished()[2].samples, 64 * kOthers);
  EXPECT_THAT(ClipsDrawn(rig, "straight", stages[2]), ElementsAre(0, 1, 2));
  ASSERT_TRUE(record->end);
  EXPECT_THAT(record->end->reason,
              AllOf(HasSubstr("384 samples in all beside the procedure's 384"),
                    HasSubstr("that of primitive_0")));

  // In the midst of it.
  rig.MustRun("first", Train(rig, "cut", kFull + kOthers + 1, compared));
  EXPECT_TRUE(FileExists(rig.Path("cut/bundle")));
  rig.MustRun("last", Train(rig, "cut", 0, compared));

  EXPECT_EQ(Fingerprints(rig, "cut", stages),
            Fingerprints(rig, "straight", stages));
}

TEST(ProcedureTest, EndsWithTheSameBitsIfItsSinglePrimitiveIsKilled) {
  const TrainingRig rig;
  const std::vector<std::string> compared = {
      "procedure.compare_single=true", "procedure.max_primitives=1",
      "procedure.recovery_samples=0", "procedure.composer_samples=0",
      absl::StrCat("procedure.hard_samples=", 64 * kLongest)};
  const std::vector<std::string> stages = {"stages/00_primitive_0",
                                           "stages/01_primitive_0_hard",
                                           "stages/02_single"};
  rig.MustRun("straight", Train(rig, "straight", 0, compared));

  const std::string single = JoinPath("cut", stages[2]);
  rig.KillAfter(single, 1, absl::Milliseconds(5),
                Train(rig, "cut", 0, compared));
  ASSERT_LT(rig.Rows(single), kLongest);
  rig.MustRun("last", Train(rig, "cut", 0, compared));

  EXPECT_EQ(Fingerprints(rig, "cut", stages),
            Fingerprints(rig, "straight", stages));
}

TEST(ProcedureTest, EndsAStageAtItsPlateau) {
  const TrainingRig rig;
  rig.MustRun("run", Train(rig, "run", kLong,
                           {absl::StrCat("procedure.full_samples=", 64 * kLong),
                            "plateau.evaluations=1", "plateau.gain=1",
                            "evaluation.interval=1"}));

  const auto record = ReadFile(rig.Path("run/procedure.json"));
  ASSERT_THAT(record, IsOk());
  EXPECT_THAT(*record, AllOf(HasSubstr("primitive_0 ended at its plateau"),
                             HasSubstr("\"end\": \"plateau\""),
                             HasSubstr("\"stalled\": 1")));
}

TEST(ProcedureTest, ShowsTheCurriculumOfItsNewestStageWithAState) {
  const TrainingRig rig;
  // The next stage is decided, and has nothing to show.
  rig.MustRun("run", Train(rig, "run", kFull));

  rig.MustRun("curriculum", {"curriculum", rig.Path("run")});

  EXPECT_THAT(rig.Output("curriculum"), HasSubstr("tumble"));
}

TEST(ProcedureTest, EndsWithTheSameBitsWhereverItsActorsAre) {
  const TrainingRig rig;
  rig.MustRun("straight", Train(rig, "straight"));
  TrainingRig::Arguments arguments = Train(rig, "apart");
  arguments[0] = "learner";
  arguments.insert(arguments.end(), {"--listen", "127.0.0.1:0"});

  const auto learner = rig.Start("learner", arguments);
  const std::string address = rig.AwaitAddress(*learner, "learner");
  const auto actor = [&](const std::string& name) {
    return rig.Start(name, {"actor", "--learner", address, "--cache",
                            rig.Path(name + "-cache"), "--threads", "1",
                            "--reconnect-seconds", "20"});
  };
  const auto first = actor("actor1"), second = actor("actor2");
  const auto status = learner->Wait(absl::Minutes(2));

  ASSERT_TRUE(status.ok() && status->ok())
      << rig.Output("learner") << rig.Output("actor1");
  EXPECT_EQ(Fingerprints(rig, "apart"), Fingerprints(rig, "straight"));
  // Who was there at the end has come to every stage and was told to go; who
  // waited between two tries meanwhile says that nobody is there any more.
  int served = 0;
  for (const auto& [name, process] :
       {std::pair("actor1", first.get()), std::pair("actor2", second.get())}) {
    const auto end = process->Wait(absl::Minutes(1));
    ASSERT_THAT(end, IsOk()) << rig.Output(name);
    if (!end->ok()) {
      EXPECT_THAT(rig.Output(name), HasSubstr("no learner at"));
      continue;
    }
    ++served;
    EXPECT_THAT(rig.Output(name), AllOf(HasSubstr("the learner is going away"),
                                        HasSubstr("the learner drains")));
  }
  EXPECT_GE(served, 1);
}

TEST(ProcedureTest, HasItsTablesAndStoresInOneProcess) {
  const TrainingRig rig;
  for (const char* flag : {"--replay", "--checkpoint"}) {
    TrainingRig::Arguments arguments = Train(rig, "run");
    arguments[0] = "learner";
    arguments.insert(arguments.end(),
                     {"--listen", "127.0.0.1:0", flag, "127.0.0.1:1"});

    EXPECT_EQ(rig.Run("learner", arguments).code, kMisused);

    EXPECT_THAT(rig.Output("learner"),
                AllOf(HasSubstr(flag), HasSubstr("with a procedure")));
  }
}

}  // namespace
}  // namespace sinew::tests
