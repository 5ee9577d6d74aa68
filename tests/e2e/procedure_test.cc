// PHC+ by the real program: however it is cut up, it ends with the same bits.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/types.h>

#include <csignal>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "common/files.h"
#include "common/policy/safetensors.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "tests/testing/training_rig.h"

namespace sinew::tests {
namespace {

using ::sinew::testing::IsOk;
using ::testing::AllOf;
using ::testing::HasSubstr;

// Evaluations ask for more than anybody can do, so that there is a hard set
// whatever is learned, and primitives are grown until there are two.
const std::vector<std::string> kStages = {
    "stages/00_primitive_0", "stages/01_primitive_0_hard",
    "stages/02_primitive_1", "stages/03_primitive_1_hard",
    "stages/04_recovery",    "stages/05_composer"};

// Iterations of 64 samples.
constexpr int kFull = 4, kOthers = 2, kLong = 8;

TrainingRig::Arguments Train(const TrainingRig& rig, const std::string& run,
                             int iterations = 0) {
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
  return rig.Train(run, iterations, more);
}

// Of what a procedure leaves: the state of each stage, and the weights that it
// came to.
std::vector<std::string> Fingerprints(const TrainingRig& rig,
                                      const std::string& run) {
  std::vector<std::string> all;
  for (const std::string& stage : kStages) {
    all.push_back(Fingerprint(
        LatestState(JoinPath(JoinPath(rig.Path(run), stage), "checkpoints"))));
  }
  const auto bundle = bundle::ReadBundle(JoinPath(rig.Path(run), "bundle"));
  EXPECT_THAT(bundle, IsOk());
  all.push_back(bundle.ok() ? SerializeSafetensors(bundle->weights) : run);
  return all;
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
  rig.MustRun("straight", Train(rig, "straight"));

  for (const std::string& stage : kStages) {
    const std::string name = absl::StrCat("killed_in_", stage.substr(7, 2));
    const auto process = rig.Start(name, Train(rig, "cut"));
    rig.AwaitRows(*process, JoinPath("cut", stage), 1);
    process->Signal(SIGKILL);
    ASSERT_THAT(process->Wait(absl::Minutes(1)), IsOk());
  }
  rig.MustRun("last", Train(rig, "cut"));

  EXPECT_EQ(Fingerprints(rig, "cut"), Fingerprints(rig, "straight"));
}

TEST(ProcedureTest, EndsWithTheSameBitsIfAnActorIsKilled) {
  const TrainingRig rig;
  // The first stage alone, and some of the next.
  const int iterations = kFull + 1;
  rig.MustRun("straight", Train(rig, "straight", iterations));

  const auto process = rig.Start("cut", Train(rig, "cut", iterations));
  rig.AwaitRows(*process, JoinPath("cut", kStages[0]), 1);
  for (const pid_t actor : ChildrenOf(process->pid())) kill(actor, SIGKILL);
  const auto end = process->Wait(absl::Minutes(1));

  ASSERT_TRUE(end.ok() && end->ok()) << rig.Output("cut");
  for (const std::string& stage : {kStages[0], kStages[1]}) {
    const std::string states = JoinPath(stage, "checkpoints");
    EXPECT_EQ(Fingerprint(LatestState(JoinPath(rig.Path("cut"), states))),
              Fingerprint(LatestState(JoinPath(rig.Path("straight"), states))));
  }
}

TEST(ProcedureTest, EndsAStageAtItsPlateau) {
  const TrainingRig rig;
  TrainingRig::Arguments train = Train(rig, "run", kLong);
  for (const std::string& assignment :
       {absl::StrCat("procedure.full_samples=", 64 * kLong),
        std::string("plateau.evaluations=1"), std::string("plateau.gain=1"),
        std::string("evaluation.interval=1")}) {
    train.insert(train.end(), {"--set", assignment});
  }

  rig.MustRun("run", train);

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

TEST(ProcedureTest, IsRefusedByALearnerForActorsElsewhere) {
  const TrainingRig rig;
  TrainingRig::Arguments learner = Train(rig, "run");
  learner[0] = "learner";
  learner.insert(learner.end(), {"--listen", "127.0.0.1:0"});

  EXPECT_EQ(rig.Run("learner", learner).code, 2);

  EXPECT_THAT(rig.Output("learner"), HasSubstr("recipe field procedure"));
}

}  // namespace
}  // namespace sinew::tests
