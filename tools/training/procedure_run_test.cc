// Whole procedures whose trainings are made up: each leaves a bundle that says
// what it was made from. tests/e2e/procedure_test.cc trains.

#include "tools/training/procedure_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/config/recipe.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "common/stop.h"
#include "common/testing/matchers.h"
#include "common/workspace_files.h"
#include "learner/procedure/stage_recipe.h"
#include "sim/world/testing/toy_world.h"
#include "tools/training/procedure_record.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr char kRecipe[] = R"(
  format_version: 1
  name: "toy"
  task { recovery { far_share: 0.5 } }
  rollouts { environments: 8 environments_per_order: 2 horizon: 8 }
  ppo { minibatch: 32 }
  evaluation { interval: 2 starts: 1 seconds: 0.5 }
  plateau { evaluations: 2 }
  procedure {
    full_samples: 640
    hard_samples: 320
    recovery_samples: 128
    composer_samples: 64
  }
  seed: 3
)";

// Clips of the toy's library (turn, sway, tumble) that each stage wins. The
// second primitive learns nothing of "tumble", so no third is grown.
const std::map<std::string, std::set<int>> kWon = {
    {"00_primitive_0", {0}}, {"01_primitive_0_hard", {0, 1}},
    {"02_primitive_1", {1}}, {"03_recovery", {0}},
    {"04_composer", {0, 1}},
};

const char kComposed[] =
    "04_composer("
    "01_primitive_0_hard(00_primitive_0()) "
    "02_primitive_1(01_primitive_0_hard(00_primitive_0())) "
    "03_recovery(02_primitive_1(01_primitive_0_hard(00_primitive_0()))))";

std::string NameOf(const std::string& path) {
  return std::filesystem::path(path).filename().string();
}

// Trainings and evaluations that are done at once; after `calls` of them, stop
// is requested instead.
class MadeUpSteps {
 public:
  explicit MadeUpSteps(int calls = 1000) : calls_(calls) {}

  ProcedureSteps Steps() {
    return {.train = [this](const auto& options) { return Train(options); },
            .evaluate =
                [this](const auto& bundle, const auto& motions, const auto& out,
                       const auto& options) {
                  EXPECT_TRUE(FileExists(JoinPath(motions, "manifest.json")));
                  EXPECT_EQ(options.starts, 1);
                  EXPECT_EQ(options.seconds, 0.5);
                  return Evaluate(bundle, out);
                }};
  }
  // The stage ends at its plateau, after three iterations.
  void SetPlateauStage(const std::string& name) { plateau_stage_ = name; }
  void SetAfterTrain(std::function<void()> call) {
    after_train_ = std::move(call);
  }
  StopToken token() const { return stop_.get_token(); }
  const std::vector<TrainingRun::Options>& trained() const { return trained_; }

 private:
  bool Spend() {
    if (calls_-- > 0) return true;
    stop_.request_stop();
    return false;
  }

  absl::StatusOr<TrainingRun::Result> Train(
      const TrainingRun::Options& options) {
    trained_.push_back(options);
    TrainingRun::Result result;
    result.iterations = 1;
    if (!Spend()) return result;
    std::vector<std::string> sources = options.primitives;
    if (!options.init.empty()) sources.push_back(options.init);
    for (std::string& source : sources) {
      source = ReadFile(JoinPath(source, "weights")).value_or("none");
    }
    const std::string bundle = JoinPath(options.directory, "bundle");
    EXPECT_THAT(MakeDirectories(bundle), IsOk());
    EXPECT_THAT(
        WriteFileAtomically(JoinPath(bundle, "weights"),
                            absl::StrCat(NameOf(options.directory), "(",
                                         absl::StrJoin(sources, " "), ")")),
        IsOk());
    // Not what counts.
    const std::string best = JoinPath(options.directory, "bundle_best");
    EXPECT_THAT(MakeDirectories(best), IsOk());
    EXPECT_THAT(WriteFileAtomically(JoinPath(best, "weights"), "best"), IsOk());
    const std::string states =
        JoinPath(options.directory, "checkpoints/artifacts");
    EXPECT_THAT(MakeDirectories(states), IsOk());
    EXPECT_THAT(WriteFileAtomically(JoinPath(states, "state-00000001"), ""),
                IsOk());
    const int64_t last = options.recipe.max_iterations();
    result.iterations = options.iterations > 0 ? options.iterations : last;
    if (NameOf(options.directory) == plateau_stage_) {
      result.iterations = 3;
      result.plateau = true;
      result.best_share = 0.5;
      result.stalled = 2;
    }
    result.samples = 64 * result.iterations;
    result.train_seconds = 60;
    result.finished = result.plateau || result.iterations >= last;
    if (after_train_) after_train_();
    return result;
  }

  absl::StatusOr<EvaluationSummary> Evaluate(const std::string& bundle,
                                             const std::string& out) {
    if (!Spend()) return absl::CancelledError("stopped");
    // What weights are evaluated says what they win, not where they lie.
    const std::string weights =
        ReadFile(JoinPath(bundle, "weights")).value_or("");
    const std::string stage = weights.substr(0, weights.find('('));
    if (!kWon.contains(stage)) {
      return absl::NotFoundError(absl::StrCat(bundle, ": no weights of a run"));
    }
    EvaluationSummary summary;
    for (int clip = 0; clip < 3; ++clip) {
      summary.clips.emplace_back();
      summary.clips.back().clip = clip;
      summary.clips.back().success = kWon.at(stage).contains(clip);
    }
    SINEW_RETURN_IF_ERROR(WriteFileAtomically(out, stage));
    return summary;
  }

  int calls_;
  std::string plateau_stage_;
  std::function<void()> after_train_;
  StopSource stop_;
  std::vector<TrainingRun::Options> trained_;
};

class ProcedureRunTest : public ::testing::Test {
 protected:
  ProcedureRunTest() : toy_(world::testing::MakeToyWorld()) {
    auto recipe = ParseRecipe(kRecipe, "test");
    EXPECT_THAT(recipe, IsOk());
    options_.recipe = WithDefaults(*std::move(recipe));
    options_.character = JoinPath(toy_.folder, "character.textproto");
    options_.motions = toy_.library_folder;
    UseRun("run");
  }

  void UseRun(const std::string& name) {
    options_.directory = JoinPath(toy_.folder, name);
  }
  absl::Status Run(MadeUpSteps& steps) const {
    return RunProcedure(options_, steps.Steps(), steps.token());
  }
  void LeaveOutTumble() const {
    const std::string file = JoinPath(toy_.library_folder, "manifest.json");
    auto manifest = nlohmann::json::parse(ReadFile(file).value_or(""));
    manifest["clips"][2]["left_out"] = true;
    EXPECT_THAT(WriteFileAtomically(file, manifest.dump()), IsOk());
  }
  std::string File(const std::string& name) const {
    return ReadFile(JoinPath(options_.directory, name)).value_or("");
  }
  ProcedureRecord Record() const {
    auto record = ParseProcedure(File("procedure.json"), "procedure.json");
    EXPECT_THAT(record, IsOk());
    return record.ok() ? *std::move(record) : ProcedureRecord();
  }

  world::testing::ToyWorld toy_;
  TrainingRun::Options options_;
};

TEST_F(ProcedureRunTest, GoesThroughAllStagesToTheBundleOfTheComposer) {
  MadeUpSteps steps;

  ASSERT_THAT(Run(steps), IsOk());

  EXPECT_EQ(File("bundle/weights"), kComposed);
  EXPECT_EQ(File("eval.json"), "04_composer");
  const ProcedureRecord record = Record();
  ASSERT_THAT(record.Finished(), SizeIs(5));
  EXPECT_THAT(record.stages[2].decision.next->clips, ElementsAre("tumble"));
  EXPECT_THAT(record.stages[3].decision.reason,
              HasSubstr("what is left cannot be learned"));
  ASSERT_TRUE(record.end.has_value());
  EXPECT_THAT(record.end->reason, HasSubstr("composer, which fails 1"));
  EXPECT_THAT(record.end->evidence.hard, ElementsAre("tumble"));
  EXPECT_EQ(record.trained_on_clips, 3);
}

TEST_F(ProcedureRunTest, GivesEachStageItsRecipeAndItsFolder) {
  MadeUpSteps steps;

  ASSERT_THAT(Run(steps), IsOk());

  ASSERT_THAT(steps.trained(), SizeIs(5));
  const TrainingRun::Options& full = steps.trained()[0];
  EXPECT_THAT(full.init, IsEmpty());
  EXPECT_EQ(full.recipe.max_iterations(), 10);
  EXPECT_THAT(full.recipe.task().start().only_clips(), IsEmpty());
  const TrainingRun::Options& hard = steps.trained()[1];
  EXPECT_EQ(hard.directory,
            JoinPath(options_.directory, "stages/01_primitive_0_hard"));
  EXPECT_THAT(hard.recipe.task().start().only_clips(),
              ElementsAre("sway", "tumble"));
  EXPECT_NE(hard.recipe.seed(), full.recipe.seed());
  EXPECT_EQ(hard.init_critic, JoinPath(full.directory, "checkpoints"));
  EXPECT_EQ(hard.init_critic_iteration, 10);
  for (const TrainingRun::Options& stage : steps.trained()) {
    EXPECT_FALSE(stage.recipe.has_procedure());
    EXPECT_THAT(ValidateRecipe(stage.recipe), IsOk());
  }
}

TEST_F(ProcedureRunTest, GoesOnFromAStageThatEndedAtItsPlateau) {
  MadeUpSteps steps;
  steps.SetPlateauStage("00_primitive_0");

  ASSERT_THAT(Run(steps), IsOk());

  const ProcedureRecord record = Record();
  ASSERT_THAT(record.Finished(), SizeIs(5));
  const learner::FinishedStage first = record.Finished()[0];
  EXPECT_TRUE(first.plateau);
  EXPECT_EQ(first.iterations, 3);
  EXPECT_EQ(first.best_share, 0.5);
  EXPECT_EQ(first.stalled, 2);
  EXPECT_FALSE(record.Finished()[1].plateau);
  EXPECT_THAT(record.stages[1].decision.reason,
              HasSubstr("primitive_0 ended at its plateau after 192 samples"));
  EXPECT_EQ(steps.trained()[1].init_critic_iteration, 3);
  EXPECT_EQ(File("bundle/weights"), kComposed);
}

TEST_F(ProcedureRunTest, BeginsWithTheWeightsOfABundleIfAsked) {
  options_.init = JoinPath(toy_.folder, "given");
  ASSERT_THAT(MakeDirectories(options_.init), IsOk());
  ASSERT_THAT(WriteFileAtomically(JoinPath(options_.init, "weights"), "given"),
              IsOk());
  MadeUpSteps steps;

  ASSERT_THAT(Run(steps), IsOk());

  EXPECT_EQ(File("stages/02_primitive_1/bundle/weights"),
            "02_primitive_1(01_primitive_0_hard(00_primitive_0(given)))");
}

TEST_F(ProcedureRunTest, GoesOnToTheSameEndWhereverItWasStopped) {
  MadeUpSteps straight;
  ASSERT_THAT(Run(straight), IsOk());
  const std::string expected = File("procedure.json");

  for (int calls = 0; calls < 10; ++calls) {
    UseRun(absl::StrCat("cut", calls));
    MadeUpSteps first(calls), second;
    ASSERT_THAT(Run(first), IsOk());
    EXPECT_EQ(File("bundle/weights"), "") << calls;
    ASSERT_THAT(Run(second), IsOk());

    EXPECT_EQ(File("bundle/weights"), kComposed) << calls;
    EXPECT_EQ(File("procedure.json"), expected) << calls;
  }
}

TEST_F(ProcedureRunTest, TrainsNothingOnceItIsOver) {
  MadeUpSteps first, second;
  ASSERT_THAT(Run(first), IsOk());
  const std::string record = File("procedure.json");

  ASSERT_THAT(Run(second), IsOk());

  EXPECT_THAT(second.trained(), IsEmpty());
  EXPECT_EQ(File("procedure.json"), record);
  EXPECT_EQ(File("bundle/weights"), kComposed);
}

TEST_F(ProcedureRunTest, CountsIterationsOverAllStages) {
  options_.iterations = 12;  // 10 of the first stage
  MadeUpSteps steps;

  ASSERT_THAT(Run(steps), IsOk());

  ASSERT_THAT(steps.trained(), SizeIs(2));
  EXPECT_EQ(steps.trained()[1].iterations, 2);
  EXPECT_THAT(Record().Finished(), SizeIs(1));
  options_.iterations = 0;
  MadeUpSteps rest;
  ASSERT_THAT(Run(rest), IsOk());
  EXPECT_EQ(File("bundle/weights"), kComposed);
}

TEST_F(ProcedureRunTest, CountsMinutesOverAllStages) {
  options_.minutes = 1.5;  // each stage takes one
  MadeUpSteps steps;

  ASSERT_THAT(Run(steps), IsOk());

  ASSERT_THAT(steps.trained(), SizeIs(2));
  EXPECT_DOUBLE_EQ(steps.trained()[0].minutes, 1.5);
  EXPECT_DOUBLE_EQ(steps.trained()[1].minutes, 0.5);
  EXPECT_EQ(File("bundle/weights"), "");
}

TEST_F(ProcedureRunTest, PassesOnWhatATrainingFailedWith) {
  MadeUpSteps steps;
  ProcedureSteps failing = steps.Steps();
  failing.train = [](const TrainingRun::Options&) {
    return absl::InternalError("no actors");
  };

  EXPECT_THAT(RunProcedure(options_, failing, steps.token()),
              StatusIs(absl::StatusCode::kInternal, HasSubstr("no actors")));

  ASSERT_THAT(Run(steps), IsOk());
  EXPECT_EQ(File("bundle/weights"), kComposed);
}

TEST(ShippedProcedures, HaveStagesThatMayAllBeRun) {
  for (const char* name : {"phc_plus", "phc_plus_g1"}) {
    const auto path =
        FindWorkspaceFile(absl::StrCat("deploy/recipes/", name, ".textproto"));
    ASSERT_THAT(path, IsOk());
    auto recipe = ParseRecipe(ReadFile(*path).value_or(""), *path);
    ASSERT_THAT(recipe, IsOk());

    EXPECT_THAT(learner::ValidateStages(WithDefaults(*std::move(recipe))),
                IsOk());
  }
}

TEST_F(ProcedureRunTest, RefusesAnotherRecipe) {
  MadeUpSteps steps(2);
  ASSERT_THAT(Run(steps), IsOk());
  options_.recipe.mutable_procedure()->set_hard_samples(6400);

  EXPECT_THAT(Run(steps), StatusIs(absl::StatusCode::kInvalidArgument,
                                   AllOf(HasSubstr("procedure.hard_samples"),
                                         HasSubstr("320 -> 6400"))));
}

TEST_F(ProcedureRunTest, RefusesALibraryThatChangesWhileItRuns) {
  MadeUpSteps steps;
  steps.SetAfterTrain([this] { LeaveOutTumble(); });

  EXPECT_THAT(Run(steps), StatusIs(absl::StatusCode::kFailedPrecondition,
                                   AllOf(HasSubstr(toy_.library_folder),
                                         HasSubstr("changed: library)"))));

  EXPECT_THAT(steps.trained(), SizeIs(1));
  EXPECT_THAT(Record().Finished(), IsEmpty());
}

TEST_F(ProcedureRunTest, RefusesResultsOfClipsThatItDoesNotKnow) {
  MadeUpSteps steps;
  ProcedureSteps more = steps.Steps();
  more.evaluate = [](const auto&, const auto&, const auto&, const auto&) {
    EvaluationSummary summary;
    summary.clips.resize(1);
    summary.clips[0].clip = 3;
    return absl::StatusOr<EvaluationSummary>(summary);
  };

  EXPECT_THAT(
      RunProcedure(options_, more, steps.token()),
      StatusIs(absl::StatusCode::kFailedPrecondition,
               AllOf(HasSubstr("the 3 clips"), HasSubstr("found clip 3"))));
}

TEST_F(ProcedureRunTest, TakesACorrectedRecipeIfNothingWasTrained) {
  MadeUpSteps none(0), steps;
  options_.recipe.mutable_task()->mutable_start()->add_only_clips("swai");
  EXPECT_THAT(Run(none),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("only_clips"), HasSubstr("\"sway\""))));
  options_.recipe.mutable_task()->mutable_start()->clear_only_clips();
  options_.recipe.mutable_procedure()->set_full_samples(6400);
  ASSERT_THAT(Run(none), IsOk());  // stopped before its first state
  ASSERT_THAT(Record().stages, SizeIs(1));
  options_.recipe.mutable_procedure()->set_full_samples(640);

  ASSERT_THAT(Run(steps), IsOk());

  EXPECT_EQ(File("bundle/weights"), kComposed);
}

TEST_F(ProcedureRunTest, RefusesAnotherLibrary) {
  MadeUpSteps steps(2);
  ASSERT_THAT(Run(steps), IsOk());
  LeaveOutTumble();

  EXPECT_THAT(Run(steps), StatusIs(absl::StatusCode::kFailedPrecondition,
                                   AllOf(HasSubstr(options_.directory),
                                         HasSubstr("changed: library)"))));
}

TEST_F(ProcedureRunTest, RefusesToMigrate) {
  options_.migrate_library = true;
  MadeUpSteps steps;

  EXPECT_THAT(Run(steps), StatusIs(absl::StatusCode::kInvalidArgument,
                                   HasSubstr("--migrate-library")));
}

TEST_F(ProcedureRunTest, RefusesARecordThatDoesNotFollow) {
  MadeUpSteps steps(3);
  ASSERT_THAT(Run(steps), IsOk());
  ProcedureRecord record = Record();
  record.stages[0].finished->failed = {"turn"};
  ASSERT_THAT(
      WriteFileAtomically(JoinPath(options_.directory, "procedure.json"),
                          PrintProcedure(record)),
      IsOk());

  MadeUpSteps fresh;
  EXPECT_THAT(Run(fresh), StatusIs(absl::StatusCode::kDataLoss,
                                   HasSubstr("01_primitive_0_hard")));
}

}  // namespace
}  // namespace sinew::tools
