// Students of a teacher, by the real program: from one bundle to another.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "absl/time/time.h"
#include "common/files.h"
#include "common/rpc/testing/socket_folder.h"
#include "common/subprocess.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "proto/sinew/v1/bundle.pb.h"
#include "proto/sinew/v1/snapshot.pb.h"
#include "tests/testing/teacher_rig.h"
#include "tests/testing/training_rig.h"

namespace sinew::tests {
namespace {

using ::sinew::testing::EqualsProto;
using ::sinew::testing::IsOk;
using ::testing::AllOf;
using ::testing::HasSubstr;

// A student with a latent, that sees more than its teacher.
const TrainingRig::Arguments& Latent() {
  static const auto& arguments = *new TrainingRig::Arguments(
      {"--set", "network.latent.width=3", "--set",
       "network.latent.encoder_hidden=8", "--set",
       "network.latent.prior_hidden=8", "--set",
       "network.latent.decoder_hidden=8", "--set",
       "distillation.memory.selector=prioritised", "--set",
       "task.observation.blocks=["
       "BLOCK_SELF_JOINT_SPACE,"
       "BLOCK_PREVIOUS_TARGET,"
       "BLOCK_REFERENCE_DIFFERENCE]"});
  return arguments;
}

// A composer over two primitives; its bundle.
std::string MakeComposedTeacher(const TrainingRig& rig) {
  const std::string one = MakeTeacher(rig, "one");
  const std::string two = MakeTeacher(rig, "two", {"--seed", "4"});
  return MakeTeacher(rig, "composer",
                     {"--set", "network.composer.primitives=2", "--set",
                      "network.composer.hidden=8", "--primitives", one, two});
}

TEST(DistillationTest, EndsWithTheSameBitsHoweverOftenItIsKilled) {
  const TrainingRig rig;
  const auto begun = Taught(MakeTeacher(rig), Latent());

  std::mt19937 random(11);
  for (int kill = 0; kill < 2; ++kill) {
    const int rows = rig.Rows("killed") + 1 + static_cast<int>(random() % 3);
    rig.KillAfter("killed", rows, absl::Milliseconds(random() % 30),
                  rig.Train("killed", 0, begun));
  }
  // Wherever the kills found it, the end is beyond.
  const int end = rig.Rows("killed") + 2;
  rig.MustRun("rest", rig.Train("killed", end, begun));
  rig.MustRun("straight", rig.Train("straight", end, begun));

  EXPECT_EQ(rig.FingerprintOf("killed"), rig.FingerprintOf("straight"));
}

TEST(DistillationTest, EndsWithTheSameBitsIfAnActorIsKilled) {
  const TrainingRig rig;
  const auto begun = Taught(MakeTeacher(rig), Latent());
  const auto with_actors = [&](const std::string& run, int iterations) {
    auto arguments = rig.Train(run, iterations, begun);
    arguments.insert(arguments.end(), {"--actors", "2", "--threads", "2"});
    return arguments;
  };

  const auto process = rig.Start("cut", with_actors("cut", 0));
  rig.AwaitRows(*process, "cut", 2);
  const std::vector<pid_t> actors = ChildrenOf(process->pid());
  ASSERT_EQ(actors.size(), 2u);
  kill(actors.front(), SIGKILL);
  rig.AwaitRows(*process, "cut", rig.Rows("cut") + 3);
  process->Signal(SIGTERM);
  const auto end = process->Wait(absl::Minutes(1));
  ASSERT_TRUE(end.ok() && end->ok()) << rig.Output("cut");
  // A run that is stopped may have its next orders open, one that ends has
  // none.
  const int last = rig.Rows("cut") + 2;
  rig.MustRun("rest", with_actors("cut", last));
  rig.MustRun("straight", rig.Train("straight", last, begun));

  EXPECT_EQ(rig.FingerprintOf("cut"), rig.FingerprintOf("straight"));
}

TEST(DistillationTest, EndsWithTheSameBitsWhereverItsTeacherIs) {
  const TrainingRig rig;
  const std::string teacher = MakeTeacher(rig);
  const Served served(rig, "served", teacher);

  rig.MustRun("here", rig.Train("here", 3, Taught(teacher, Latent())));
  rig.MustRun("there", rig.Train("there", 3, Taught(served.address, Latent())));

  EXPECT_EQ(rig.FingerprintOf("there"), rig.FingerprintOf("here"));
  EXPECT_THAT(ProvenanceOf(rig, "there"),
              EqualsProto(ProvenanceOf(rig, "here")));
  EXPECT_EQ(ProvenanceOf(rig, "there").sources_size(), 1);
}

TEST(DistillationTest, LearnsFromAComposerWhereverItIs) {
  const TrainingRig rig;
  const std::string teacher = MakeComposedTeacher(rig);
  rig.MustRun("local", rig.Train("local", 3, Taught(teacher)));

  const Served served(rig, "served", teacher);
  rig.MustRun("remote", rig.Train("remote", 3, Taught(served.address)));

  EXPECT_EQ(rig.FingerprintOf("remote"), rig.FingerprintOf("local"));
}

TEST(DistillationTest, GoesOnWithAnotherReplicaWhereOneIsKilled) {
  const TrainingRig rig;
  const std::string teacher = MakeTeacher(rig);
  const Served first(rig, "first", teacher), second(rig, "second", teacher);
  rig.MustRun("straight", rig.Train("straight", 6, Taught(teacher)));

  const auto train = rig.Start(
      "run", rig.Train("run", 6, Taught(first.address + "," + second.address)));
  rig.AwaitRows(*train, "run", 1);
  first.process->Signal(SIGKILL);
  const auto end = train->Wait(absl::Minutes(2));

  ASSERT_TRUE(end.ok() && end->ok()) << rig.Output("run");
  EXPECT_EQ(rig.FingerprintOf("run"), rig.FingerprintOf("straight"));
}

TEST(DistillationTest, EndsWhereTheOnlyTeacherIsKilledAndGoesOnWithItsNext) {
  const TrainingRig rig;
  const std::string teacher = MakeTeacher(rig);
  const rpc::SocketFolder folder;
  const std::string address = folder.Address("teacher");
  {
    const Served served(rig, "first", teacher, address);
    const auto train = rig.Start(
        "run", rig.Train("run", 1000,
                         Taught(address, {"--teacher-patience", "5",
                                          "--teacher-timeout", "5"})));
    rig.AwaitRows(*train, "run", 1);

    served.process->Signal(SIGKILL);
    const auto end = train->Wait(absl::Minutes(2));

    ASSERT_TRUE(end.ok()) << rig.Output("run");
    EXPECT_EQ(end->code, kFailed);
    EXPECT_THAT(rig.Output("run"), HasSubstr("teacher " + address));
  }
  const Served served(rig, "second", teacher, address);
  const int iterations = rig.Rows("run") + 2;
  rig.MustRun("rest", rig.Train("run", iterations, Taught(address)));
  rig.MustRun("straight", rig.Train("straight", iterations, Taught(teacher)));

  EXPECT_EQ(rig.FingerprintOf("run"), rig.FingerprintOf("straight"));
}

TEST(DistillationTest, GivesABundleWithALatentThatNamesItsTeacher) {
  const TrainingRig rig;
  const std::string teacher = MakeTeacher(rig);

  rig.MustRun("run", rig.Train("run", 2, Taught(teacher, Latent())));

  const std::string folder = JoinPath(rig.Path("run"), "bundle");
  const auto bundle = bundle::ReadBundle(folder);
  ASSERT_THAT(bundle, IsOk());
  EXPECT_EQ(bundle->manifest.latent_width(), 3);
  const auto& sources = bundle->manifest.provenance().sources();
  ASSERT_EQ(sources.size(), 1);
  EXPECT_EQ(sources[0].role(), "teacher");
  const auto of_teacher = bundle::ReadBundle(teacher);
  ASSERT_THAT(of_teacher, IsOk());
  EXPECT_EQ(sources[0].manifest_sha256(),
            of_teacher->manifest.manifest_sha256());
  rig.MustRun("verify", {"verify", folder, "--skip-onnx"});
  const auto metrics = ReadFile(JoinPath(rig.Path("run"), "metrics.jsonl"));
  ASSERT_THAT(metrics, IsOk());
  EXPECT_THAT(*metrics, AllOf(HasSubstr("\"distillation\":{\"action_loss\""),
                              HasSubstr("\"latent_kl\"")));
}

// As PULSE has it: prior and decoder see heights, places, turns and velocities
// of all bodies. Of the toy's 5: 15 * 5 - 2 numbers, and 24 * 5 of the goal.
TEST(DistillationTest, GivesALatentThatSeesTheBodies) {
  const TrainingRig rig;
  const TrainingRig::Arguments bodies = {
      "--set", "task.observation.blocks=[self_bodies,reference_bodies]"};
  const std::string teacher = MakeTeacher(rig, "teacher", bodies);
  TrainingRig::Arguments arguments = Taught(teacher, Latent());
  arguments.insert(arguments.end(), bodies.begin(), bodies.end());

  rig.MustRun("run", rig.Train("run", 2, arguments));

  const std::string folder = JoinPath(rig.Path("run"), "bundle");
  const auto bundle = bundle::ReadBundle(folder);
  ASSERT_THAT(bundle, IsOk());
  EXPECT_EQ(bundle->manifest.self_observation_width(), 73);
  EXPECT_EQ(bundle->manifest.observation_width(), 73 + 120);
  EXPECT_EQ(bundle->manifest.latent_width(), 3);
  rig.MustRun("verify", {"verify", folder, "--skip-onnx"});
  rig.MustRun("sample",
              {"sample", "--bundle", folder, "--motions",
               rig.ToyFile("library"), "--seconds", "0.5", "--count", "4"});
}

TEST(DistillationTest, TrainsAStudentWithoutABottleneck) {
  const TrainingRig rig;
  const std::string teacher = MakeTeacher(rig);

  rig.MustRun("run", rig.Train("run", 2, Taught(teacher)));

  rig.MustRun("verify",
              {"verify", JoinPath(rig.Path("run"), "bundle"), "--skip-onnx"});
}

// Of all rows of a run's metrics.
int64_t SumOf(const TrainingRig& rig, const std::string& run,
              const std::string& column) {
  std::istringstream rows(
      ReadFile(JoinPath(rig.Path(run), "metrics.jsonl")).value_or(""));
  int64_t sum = 0;
  for (std::string row; std::getline(rows, row);) {
    sum += nlohmann::json::parse(row).at(column).get<int64_t>();
  }
  return sum;
}

// As learner/curriculum/bin_sums.h has it.
double FailureRate(const v1::CurriculumTable::Bin& bin) {
  return (bin.recent_failures() + 1) / (bin.recent_passages() + 2);
}

double PerFrame(const v1::CurriculumTable::Bin& bin) {
  return bin.probability() / bin.num_frames();
}

// The toy's clips are shorter than a bin: each is one. A student that has
// learnt next to nothing stands ("sway"), and does not walk ("turn").
TEST(DistillationTest, StartsMoreOftenWhereTheStudentFails) {
  const TrainingRig rig;
  const std::string teacher = MakeTeacher(rig);
  TrainingRig::Arguments arguments = Taught(teacher, Latent());
  arguments.insert(arguments.end(), {"--set", "task.start.rule=adaptive_bins"});

  rig.MustRun("run", rig.Train("run", 20, arguments));

  const v1::CurriculumTable table = rig.StateOf("run").counters.curriculum();
  ASSERT_EQ(table.bins_size(), 3);
  int64_t visits = 0, failures = 0, frames = 0;
  for (const v1::CurriculumTable::Bin& bin : table.bins()) {
    EXPECT_GT(bin.visits(), 0) << bin.clip();
    visits += bin.visits();
    failures += bin.failures();
    frames += bin.num_frames();
  }
  EXPECT_EQ(visits, SumOf(rig, "run", "episodes"));
  EXPECT_EQ(failures, SumOf(rig, "run", "failed_episodes"));
  EXPECT_GT(failures, 0);
  const auto [easiest, hardest] = std::minmax_element(
      table.bins().begin(), table.bins().end(),
      [](const v1::CurriculumTable::Bin& a, const v1::CurriculumTable::Bin& b) {
        return FailureRate(a) < FailureRate(b);
      });
  ASSERT_GT(FailureRate(*hardest), FailureRate(*easiest) + 0.2);
  const double uniform = 1.0 / static_cast<double>(frames);
  EXPECT_GT(PerFrame(*hardest), uniform);
  EXPECT_LT(PerFrame(*easiest), uniform);
}

TEST(DistillationTest, TakesTeacherAndRecipeTogetherOrNeither) {
  const TrainingRig rig;
  const std::string teacher = MakeTeacher(rig);

  EXPECT_EQ(rig.Run("lacks", rig.Train("lacks", 1, Taught(""))).code, kMisused);
  EXPECT_EQ(rig.Run("has", rig.Train("has", 1, {"--teacher", teacher})).code,
            kMisused);

  EXPECT_THAT(rig.Output("lacks"),
              AllOf(HasSubstr("--teacher"), HasSubstr("found none")));
  EXPECT_THAT(rig.Output("has"),
              AllOf(HasSubstr("--teacher"), HasSubstr("has no distillation")));
}

TEST(DistillationTest, RefusesATeacherThatDoesNotFit) {
  const TrainingRig rig;
  const std::string sees_more = MakeTeacher(
      rig, "sees_more", {"--set", "task.observation.frames_ahead=[1,2]"});
  const std::string acts_otherwise =
      MakeTeacher(rig, "acts_otherwise", {"--set", "task.action.scale=0.3"});

  EXPECT_EQ(rig.Run("one", rig.Train("one", 1, Taught(sees_more))).code,
            kMisused);
  EXPECT_EQ(rig.Run("two", rig.Train("two", 1, Taught(acts_otherwise))).code,
            kMisused);

  EXPECT_THAT(rig.Output("one"),
              AllOf(HasSubstr(sees_more), HasSubstr("observation")));
  EXPECT_THAT(rig.Output("two"),
              AllOf(HasSubstr(acts_otherwise), HasSubstr("teacher_action")));
}

TEST(DistillationTest, GoesOnWithItsOwnTeacherAlone) {
  const TrainingRig rig;
  const std::string teacher = MakeTeacher(rig);
  const std::string other = MakeTeacher(rig, "other", {"--seed", "4"});
  rig.MustRun("begin", rig.Train("run", 1, Taught(teacher)));

  EXPECT_FALSE(rig.Run("another", rig.Train("run", 2, Taught(other))).ok());

  EXPECT_THAT(rig.Output("another"),
              AllOf(HasSubstr("--teacher"), HasSubstr("manifest_sha256")));
  rig.MustRun("rest", rig.Train("run", 2, Taught(teacher)));
}

}  // namespace
}  // namespace sinew::tests
