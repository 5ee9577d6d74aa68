#ifndef SINEW_TOOLS_TRAINING_TESTING_PROCEDURE_RIG_H_
#define SINEW_TOOLS_TRAINING_TESTING_PROCEDURE_RIG_H_

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/config/recipe.h"
#include "common/evaluation/evaluation_summary.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "common/stop.h"
#include "common/testing/matchers.h"
#include "sim/world/testing/toy_world.h"
#include "tools/training/procedure_record.h"
#include "tools/training/procedure_run.h"

namespace sinew::tools {

// Whole procedures in the toy world whose trainings are made up: each leaves a
// bundle that says what it was made from.

inline constexpr char kProcedureRecipe[] = R"(
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
// second primitive learns nothing of "tumble", so no third is grown. A single
// primitive, where one is asked for, wins more than all others.
inline const std::map<std::string, std::set<int>> kWon = {
    {"00_primitive_0", {0}}, {"01_primitive_0_hard", {0, 1}},
    {"02_primitive_1", {1}}, {"03_recovery", {0}},
    {"04_composer", {0, 1}}, {"05_single", {0, 1, 2}},
};

inline constexpr char kComposed[] =
    "04_composer("
    "01_primitive_0_hard(00_primitive_0()) "
    "02_primitive_1(01_primitive_0_hard(00_primitive_0())) "
    "03_recovery(02_primitive_1(01_primitive_0_hard(00_primitive_0()))))";

inline std::string NameOf(const std::string& path) {
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
                  fallen_.push_back(options.fallen.value_or(0));
                  EXPECT_TRUE(FileExists(JoinPath(motions, "manifest.json")));
                  EXPECT_EQ(options.starts, 1);
                  EXPECT_EQ(options.seconds, 0.5);
                  return Evaluate(bundle, out, options.fallen);
                }};
  }
  // The stage ends at its plateau, after three iterations.
  void SetPlateauStage(const std::string& name) { plateau_stage_ = name; }
  void SetAfterTrain(std::function<void()> call) {
    after_train_ = std::move(call);
  }
  StopToken token() const { return stop_.get_token(); }
  const std::vector<TrainingRun::Options>& trained() const { return trained_; }
  // Fallen starts that each stage was evaluated from.
  const std::vector<int>& fallen() const { return fallen_; }

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
    EXPECT_THAT(MakeDirectories(bundle), ::sinew::testing::IsOk());
    EXPECT_THAT(
        WriteFileAtomically(JoinPath(bundle, "weights"),
                            absl::StrCat(NameOf(options.directory), "(",
                                         absl::StrJoin(sources, " "), ")")),
        ::sinew::testing::IsOk());
    // Not what counts.
    const std::string best = JoinPath(options.directory, "bundle_best");
    EXPECT_THAT(MakeDirectories(best), ::sinew::testing::IsOk());
    EXPECT_THAT(WriteFileAtomically(JoinPath(best, "weights"), "best"),
                ::sinew::testing::IsOk());
    const std::string states =
        JoinPath(options.directory, "checkpoints/artifacts");
    EXPECT_THAT(MakeDirectories(states), ::sinew::testing::IsOk());
    EXPECT_THAT(WriteFileAtomically(JoinPath(states, "state-00000001"), ""),
                ::sinew::testing::IsOk());
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

  absl::StatusOr<evaluation::EvaluationFigures> Evaluate(
      const std::string& bundle, const std::string& out,
      std::optional<int> fallen) {
    if (!Spend()) return absl::CancelledError("stopped");
    // What weights are evaluated says what they win, not where they lie.
    const std::string weights =
        ReadFile(JoinPath(bundle, "weights")).value_or("");
    const std::string stage = weights.substr(0, weights.find('('));
    if (!kWon.contains(stage)) {
      return absl::NotFoundError(absl::StrCat(bundle, ": no weights of a run"));
    }
    evaluation::EvaluationFigures figures;
    for (int clip = 0; clip < 3; ++clip) {
      ClipSummary& summary = figures.policy.clips.emplace_back();
      summary.clip = clip;
      summary.success = kWon.at(stage).contains(clip);
    }
    if (fallen) {
      figures.fallen.emplace();
      figures.fallen->starts = *fallen;
      figures.fallen->policy = {.recovered_3_s = 0.25, .recovered_5_s = 0.5};
    }
    SINEW_RETURN_IF_ERROR(WriteFileAtomically(out, stage));
    return figures;
  }

  int calls_;
  std::string plateau_stage_;
  std::function<void()> after_train_;
  StopSource stop_;
  std::vector<TrainingRun::Options> trained_;
  std::vector<int> fallen_;
};

// A procedure in the toy world, each run in a folder of its own.
class ProcedureRunTest : public ::testing::Test {
 protected:
  ProcedureRunTest() : toy_(world::testing::MakeToyWorld()) {
    auto recipe = ParseRecipe(kProcedureRecipe, "test");
    EXPECT_THAT(recipe, ::sinew::testing::IsOk());
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
  // A bundle for --init, whose manifest and weights are its name.
  void GiveInit(const std::string& name) {
    options_.init = JoinPath(toy_.folder, name);
    EXPECT_THAT(MakeDirectories(options_.init), ::sinew::testing::IsOk());
    for (const char* file : {"manifest.json", "weights"}) {
      EXPECT_THAT(WriteFileAtomically(JoinPath(options_.init, file), name),
                  ::sinew::testing::IsOk());
    }
  }
  void LeaveOutTumble() const {
    world::testing::LeaveOutOnDisk(2, toy_.library_folder);
  }
  std::string File(const std::string& name) const {
    return ReadFile(JoinPath(options_.directory, name)).value_or("");
  }
  ProcedureRecord Record() const {
    auto record = ParseProcedure(File("procedure.json"), "procedure.json");
    EXPECT_THAT(record, ::sinew::testing::IsOk());
    return record.ok() ? *std::move(record) : ProcedureRecord();
  }

  world::testing::ToyWorld toy_;
  TrainingRun::Options options_;
};

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_TESTING_PROCEDURE_RIG_H_
