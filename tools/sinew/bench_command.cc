#include "tools/sinew/bench_command.h"

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "absl/strings/string_view.h"
#include "common/build_info.h"
#include "common/cpu.h"
#include "common/files.h"
#include "common/output_file.h"
#include "common/status_macros.h"
#include "sim/character/character.h"
#include "sim/import/importer.h"
#include "sim/motion/library.h"
#include "sim/world/fallen_states.h"
#include "tools/bench/actor_figures.h"
#include "tools/bench/actor_memory.h"
#include "tools/bench/distillation_figures.h"
#include "tools/bench/learner_figures.h"
#include "tools/bench/teacher_figures.h"
#include "tools/bench/transport_figures.h"
#include "tools/sinew/resources.h"

namespace sinew::tools {
namespace {

using Json = nlohmann::ordered_json;

// Environments whose memory is measured, and the minibatch of learner figures.
constexpr int kEnvironments = 256;
constexpr int kMinibatch = 4096;
constexpr int kLearnerEnvironments = 128;
constexpr int kLearnerOrders = 16;
// Of a student, per update of a learner.
constexpr int kMinibatchesOfUpdate = 8;

struct BenchOptions {
  std::string out;
  std::string recipe = "track_clip";
  std::string character = "humanoid";
  std::string motions;  // empty: the walk of the pybullet wheel
  int rounds = 8;       // orders per thread
  int updates = 6;      // of each learner
};

absl::Status CheckOptions(const BenchOptions& options) {
  for (const auto& [name, value] : {std::pair("--rounds", options.rounds),
                                    std::pair("--updates", options.updates)}) {
    if (value < 1) {
      return absl::InvalidArgumentError(
          absl::StrCat(name, ": expected >= 1, found ", value));
    }
  }
  return absl::OkStatus();
}

// The library to act in: as given, or imported beside the result.
absl::StatusOr<std::unique_ptr<motion::Library>> LoadMotions(
    const BenchOptions& options, const character::Character& character) {
  if (!options.motions.empty()) return motion::Library::Load(options.motions);
  SINEW_ASSIGN_OR_RETURN(
      const std::string clip,
      FindResource(
          "pybullet_data/pybullet_data/data/motions/humanoid3d_walk.txt"));
  const std::string folder = absl::StrCat(options.out, ".motions");
  std::vector<import::ClipReport> reports;
  SINEW_RETURN_IF_ERROR(
      import::ImportFiles(character, {clip}, {}, folder, &reports));
  return motion::Library::Load(folder);
}

// "model name" of the first processor; empty where the system does not tell.
std::string CpuModel() {
  const absl::StatusOr<std::string> text =
      ReadFile("/proc/cpuinfo", /*max_bytes=*/1 << 20);
  if (!text.ok()) return "";
  for (absl::string_view line : absl::StrSplit(*text, '\n')) {
    const std::pair<absl::string_view, absl::string_view> field =
        absl::StrSplit(line, absl::MaxSplits(':', 1));
    if (absl::StripAsciiWhitespace(field.first) == "model name") {
      return std::string(absl::StripAsciiWhitespace(field.second));
    }
  }
  return "";
}

Json Context() {
  return {{"cpu_model", CpuModel()},
          {"cpu_class", CpuClass()},
          {"cpus", AvailableCpus()},
          {"build", BuildIdentity()},
          {"clock",
           "CPU seconds of each thread, the fastest of a round, medians over "
           "rounds"}};
}

Json ActorJson(const bench::ActorFigures& figures) {
  return {{"threads", figures.threads},
          {"ratio", figures.ratio},
          {"other_us", figures.other_us},
          {"products_us", figures.products_us},
          {"step_us", figures.step_us},
          {"rollout_mj_steps_per_s", figures.rollout_steps_per_s},
          {"raw_mj_steps_per_s", figures.raw_steps_per_s}};
}

absl::StatusOr<Json> ActorSection(
    const BenchOptions& options,
    const std::shared_ptr<const actor::RolloutAssets>& assets,
    const v1::Snapshot& snapshot) {
  Json section;
  for (const int threads : {1, 2}) {
    SINEW_ASSIGN_OR_RETURN(
        const bench::ActorFigures figures,
        bench::MeasureActor(
            {.threads = threads,
             .rounds = options.rounds,
             .environments =
                 assets->recipe().rollouts().environments_per_order(),
             .horizon = assets->recipe().rollouts().horizon()},
            assets, snapshot));
    absl::FPrintF(stderr,
                  "actor, %d threads: ratio %.3f, not physics %.1f us of %.1f "
                  "us, products alone %.1f us\n",
                  threads, figures.ratio, figures.other_us, figures.step_us,
                  figures.products_us);
    if (threads == 1) {
      section = ActorJson(figures);
    } else {
      section["two_threads"] = ActorJson(figures);
    }
  }
  return section;
}

Json LearnerJson(const bench::LearnerFigures& figures) {
  return {{"samples_per_s", figures.samples_per_s},
          {"flops_per_s", figures.flops_per_s},
          {"cpu_flops_per_s", figures.cpu_flops_per_s}};
}

// Updates at minibatch 4096: float32 on one rank and on two, bfloat16. The
// recipe's networks, on a batch of two such minibatches whatever its own batch;
// those of a recipe that distils, as PPO would train them.
absl::StatusOr<Json> LearnerSection(const BenchOptions& options,
                                    const actor::RolloutAssets& assets) {
  v1::Recipe recipe = assets.recipe();
  recipe.clear_distillation();
  recipe.mutable_ppo()->set_minibatch(kMinibatch);
  recipe.mutable_rollouts()->set_environments(kLearnerEnvironments);
  recipe.mutable_rollouts()->set_environments_per_order(kLearnerEnvironments /
                                                        kLearnerOrders);
  recipe.mutable_rollouts()->set_horizon(2 * kMinibatch / kLearnerEnvironments);
  SINEW_ASSIGN_OR_RETURN(
      const bench::LearnerRatios ratios,
      bench::MeasureLearner(
          recipe,
          {.observation = assets.task().observation_width(),
           .self_observation = assets.task().self_observation_width(),
           .action = assets.task().action_width()},
          options.updates));
  Json section = LearnerJson(ratios.one_rank);
  section["minibatch"] = kMinibatch;
  section["gemm_ratio"] = ratios.gemm_ratio;
  section["cpu_gemm_ratio"] = ratios.cpu_gemm_ratio;
  section["gemm_flops_per_s"] = ratios.gemm_flops_per_s;
  section["two_rank_ratio"] = ratios.two_ranks_ratio;
  section["two_ranks"] = LearnerJson(ratios.two_ranks);
  if (ratios.bfloat16_ratio.has_value()) {
    section["bfloat16_ratio"] = *ratios.bfloat16_ratio;
  } else {
    section["bfloat16_ratio"] = nullptr;
    section["bfloat16_reason"] = ratios.bfloat16_reason;
  }
  absl::FPrintF(stderr, "learner: gemm ratio %.3f, two ranks %.2f times one\n",
                ratios.gemm_ratio, ratios.two_ranks_ratio);
  return section;
}

// Minibatches of a student: the recipe's, or, of one that does not distil,
// pulse's networks on this task's columns.
absl::StatusOr<Json> DistillationSection(const BenchOptions& options,
                                         const actor::RolloutAssets& assets) {
  const bench::LearnerWidths widths = {
      .observation = assets.task().observation_width(),
      .self_observation = assets.task().self_observation_width(),
      .action = assets.task().action_width()};
  v1::Recipe recipe = assets.recipe();
  if (!recipe.has_distillation()) {
    SINEW_ASSIGN_OR_RETURN(recipe, LoadRecipe("pulse", {}));
    if (widths.self_observation == 0 ||
        widths.self_observation == widths.observation) {
      return Json{{"recipe", recipe.name()},
                  {"rows_per_s", nullptr},
                  {"reason",
                   "a latent needs an observation that begins with the body's "
                   "own columns and goes on with others"}};
    }
  }
  SINEW_ASSIGN_OR_RETURN(
      const bench::DistillationFigures figures,
      bench::MeasureDistillation(recipe, widths,
                                 kMinibatchesOfUpdate * options.updates));
  Json section = {{"recipe", recipe.name()},
                  {"minibatch", recipe.distillation().minibatch()},
                  {"rows_per_s", figures.rows_per_s},
                  {"flops_per_s", figures.flops_per_s}};
  std::string rounded;
  if (figures.bfloat16_ratio.has_value()) {
    section["bfloat16_ratio"] = *figures.bfloat16_ratio;
    rounded =
        absl::StrFormat("bfloat16 %.2f times float32", *figures.bfloat16_ratio);
  } else {
    section["bfloat16_ratio"] = nullptr;
    section["bfloat16_reason"] = figures.bfloat16_reason;
    rounded = "no bfloat16";
  }
  absl::FPrintF(stderr, "distillation: %s, %.0f rows/s on one thread\n",
                rounded, figures.rows_per_s);
  return section;
}

// Segments of this task through replay, beside the rate at which two threads of
// actors make them.
absl::StatusOr<Json> TransportSection(const actor::RolloutAssets& assets,
                                      double mj_steps_per_s) {
  const v1::Recipe& recipe = assets.recipe();
  const v1::Rollouts& rollouts = recipe.rollouts();
  bench::TransportOptions options;
  options.observation_width = assets.task().observation_width();
  options.action_width = assets.task().action_width();
  options.environments = rollouts.environments_per_order();
  options.steps = rollouts.horizon();
  options.orders = rollouts.environments() / rollouts.environments_per_order();
  options.samples_per_s = mj_steps_per_s * recipe.physics().control_hz() /
                          recipe.physics().physics_hz();
  SINEW_ASSIGN_OR_RETURN(const bench::TransportFigures figures,
                         bench::MeasureTransport(options));
  absl::FPrintF(
      stderr, "transport: %.2f GB/s, %.1f %% of a core at %.0f samples/s\n",
      figures.gb_per_s, 100 * figures.core_share, options.samples_per_s);
  return Json{{"gb_per_s", figures.gb_per_s},
              {"core_s_per_gb", figures.core_s_per_gb},
              {"bytes_per_sample", figures.bytes_per_sample},
              {"samples_per_s", options.samples_per_s},
              {"core_share", figures.core_share}};
}

// The recipe's policy as a teacher.
absl::StatusOr<Json> TeacherSection(const actor::RolloutAssets& assets) {
  bench::TeacherOptions options;
  options.observation_width = assets.task().observation_width();
  options.action_width = assets.task().action_width();
  options.network = assets.recipe().network();
  SINEW_ASSIGN_OR_RETURN(const bench::TeacherFigures figures,
                         bench::MeasureTeacher(options));
  absl::FPrintF(stderr,
                "teacher: %.3f of the executor's %.0f rows/s; one row %.2f ms, "
                "99th percentile %.2f ms\n",
                figures.throughput_ratio, figures.executor_rows_per_s,
                figures.latency_p50_ms, figures.latency_p99_ms);
  return Json{
      {"throughput_ratio", figures.throughput_ratio},
      {"rows_per_s", figures.rows_per_s},
      {"executor_rows_per_s", figures.executor_rows_per_s},
      {"latency_ms",
       {{"p50", figures.latency_p50_ms}, {"p99", figures.latency_p99_ms}}}};
}

absl::Status RunBench(const BenchOptions& options, const StopToken& stop) {
  SINEW_RETURN_IF_ERROR(CheckOptions(options));
  SINEW_RETURN_IF_ERROR(CheckOutputFile(options.out));
  SINEW_ASSIGN_OR_RETURN(const v1::Recipe recipe,
                         LoadRecipe(options.recipe, {}));
  SINEW_ASSIGN_OR_RETURN(
      auto character,
      character::Character::Load(options.character, recipe.physics()));
  SINEW_ASSIGN_OR_RETURN(auto library, LoadMotions(options, *character));
  SINEW_RETURN_IF_ERROR(library->Verify());
  SINEW_ASSIGN_OR_RETURN(auto fallen,
                         world::FallenStates::MakeFor(*character, recipe));
  SINEW_ASSIGN_OR_RETURN(
      const std::shared_ptr<const actor::RolloutAssets> assets,
      actor::RolloutAssets::FromParts(recipe, std::move(character),
                                      std::move(library), std::move(fallen)));
  SINEW_ASSIGN_OR_RETURN(const v1::Snapshot snapshot,
                         bench::IdlePolicy(*assets));

  Json result;
  result["context"] = Context();
  // Memory first: later sections leave freed memory behind that would be used
  // again.
  SINEW_ASSIGN_OR_RETURN(
      const bench::MemoryFigures memory,
      bench::MeasureMemory(kEnvironments, recipe.rollouts().horizon(), assets,
                           snapshot));
  result["memory"] = {{"environments", memory.environments},
                      {"actor_mb", memory.actor_mb},
                      {"per_environment_kb", memory.per_environment_kb}};
  SINEW_ASSIGN_OR_RETURN(result["actor"],
                         ActorSection(options, assets, snapshot));
  if (stop.stop_requested()) return absl::CancelledError("bench stopped");
  SINEW_ASSIGN_OR_RETURN(result["learner"], LearnerSection(options, *assets));
  if (stop.stop_requested()) return absl::CancelledError("bench stopped");
  SINEW_ASSIGN_OR_RETURN(result["distillation"],
                         DistillationSection(options, *assets));
  if (stop.stop_requested()) return absl::CancelledError("bench stopped");
  SINEW_ASSIGN_OR_RETURN(
      result["transport"],
      TransportSection(*assets,
                       result["actor"]["two_threads"]["rollout_mj_steps_per_s"]
                           .get<double>()));
  if (stop.stop_requested()) return absl::CancelledError("bench stopped");
  SINEW_ASSIGN_OR_RETURN(result["teacher"], TeacherSection(*assets));
  return WriteFileAtomically(options.out, result.dump(2) + "\n");
}

}  // namespace

void AddBenchCommand(CLI::App& app, Action& action) {
  auto options = std::make_shared<BenchOptions>();
  auto* command = AddSubcommand<BenchOptions>(
      app, "bench", "benchmarks, as ratios measured in one run", options,
      action, RunBench);
  command->add_option("--out", options->out, "JSON file")->required();
  command->add_option("--recipe", options->recipe, "name of one, or a file")
      ->capture_default_str();
  command
      ->add_option("--character", options->character, "name of one, or a file")
      ->capture_default_str();
  command->add_option("--motions", options->motions,
                      "motion library; a walking clip if unset");
  command->add_option("--rounds", options->rounds, "orders per thread")
      ->capture_default_str();
  command
      ->add_option("--updates", options->updates,
                   "updates of each learner; a student learns eight "
                   "minibatches for each")
      ->capture_default_str();
}

}  // namespace sinew::tools
