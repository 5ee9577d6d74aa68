#include "tools/sinew/quickstart_command.h"

#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/time/time.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "common/subprocess.h"
#include "sim/motion/library.h"
#include "tools/sinew/finite_range.h"
#include "tools/sinew/resources.h"

namespace sinew::tools {
namespace {

// Patience with one step beyond the minutes that it trains.
constexpr absl::Duration kPatience = absl::Minutes(30);
// For a step to save what it has after Ctrl-C.
constexpr absl::Duration kGrace = absl::Seconds(60);

struct QuickstartOptions {
  std::string out = "runs/quickstart";
  std::string clip = "humanoid3d_walk";
  double minutes = 5;
  uint64_t seed = 1;
};

// A command that a user would type.
struct Step {
  std::string title;
  std::vector<std::string> arguments;
  // Left out if this file is there.
  std::string result;
};

constexpr int kNumSteps = 5;

std::string Motions(const QuickstartOptions& options) {
  return JoinPath(options.out, "motions");
}

// From the clip to bundles.
std::vector<Step> LearningSteps(const QuickstartOptions& options,
                                const std::string& clip_file) {
  const std::string motions = Motions(options);
  const std::string minutes = absl::StrFormat("%g", options.minutes);
  return {
      {"import a recorded walk",
       {"motion", "import", "--character", "humanoid", "--provenance",
        "DeepMimic (Peng et al. 2018), from the pybullet 3.2.7 wheel",
        "--licence", "MIT", "--out", motions, clip_file},
       JoinPath(motions, "manifest.json")},
      {absl::StrCat("train a policy to follow it, ", minutes, " minutes"),
       {"train", "--recipe", "track_clip", "--motions", motions, "--run",
        options.out, "--minutes", minutes, "--seed",
        absl::StrCat(options.seed)},
       ""},
  };
}

// From a bundle to the report: the best evaluated one, if training was long
// enough for an evaluation.
std::vector<Step> ShowingSteps(const QuickstartOptions& options) {
  const std::string& run = options.out;
  const std::string best = JoinPath(run, "bundle_best");
  const std::string bundle = FileExists(best) ? best : JoinPath(run, "bundle");
  return {
      {"evaluate the bundle: 32 starts, 10 s each",
       {"eval", "--bundle", bundle, "--motions", Motions(options), "--starts",
        "32", "--out", JoinPath(run, "eval.json")},
       ""},
      {"check the bundle in every runtime", {"verify", bundle}, ""},
      {"write the report", {"report", "--run", run}, ""},
  };
}

// Quotes what a shell would split.
std::string ShellWord(const std::string& word) {
  const bool plain = word.find_first_of(" ()\"'") == std::string::npos;
  return plain ? word : absl::StrCat("'", word, "'");
}

absl::Status RunStep(const Step& step, int number, absl::Duration patience,
                     const StopToken& stop) {
  absl::FPrintF(stderr, "\n[%d/%d] %s\n", number, kNumSteps, step.title);
  std::vector<std::string> words;
  for (const std::string& word : step.arguments) {
    words.push_back(ShellWord(word));
  }
  absl::FPrintF(stderr, "$ ./sinew %s\n", absl::StrJoin(words, " "));
  if (!step.result.empty() && FileExists(step.result)) {
    absl::FPrintF(stderr, "(done before: %s)\n", step.result);
    return absl::OkStatus();
  }
  std::vector<std::string> argv = {"/proc/self/exe"};
  SINEW_ASSIGN_OR_RETURN(argv[0], OwnBinary());
  argv.insert(argv.end(), step.arguments.begin(), step.arguments.end());
  SINEW_ASSIGN_OR_RETURN(const std::unique_ptr<Subprocess> child,
                         Subprocess::Start({.argv = argv, .grace = kGrace}));
  const auto waited = child->Wait(patience, stop);
  const ExitStatus status = waited.ok() ? *waited : child->Terminate(kGrace);
  if (stop.stop_requested()) return absl::CancelledError("quickstart stopped");
  SINEW_RETURN_IF_ERROR(waited.status());
  if (status.ok()) return absl::OkStatus();
  return absl::InternalError(absl::StrCat("quickstart: \"", step.title,
                                          "\" ended with ", status.ToString(),
                                          " (its message is above)"));
}

// What a folder was imported from stays its clip: the import is left out where
// there is a library.
absl::Status CheckClip(const QuickstartOptions& options) {
  const std::string motions = Motions(options);
  if (!FileExists(JoinPath(motions, "manifest.json"))) return absl::OkStatus();
  SINEW_ASSIGN_OR_RETURN(const auto library, motion::Library::Load(motions));
  if (library->FindClip(options.clip) >= 0) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      "--clip: expected ", library->clip(0).name(), ", which ", motions,
      " holds, found ", options.clip, "; another clip needs another --out"));
}

absl::Status RunQuickstart(const QuickstartOptions& options,
                           const StopToken& stop) {
  if (!(options.minutes > 0)) {
    return absl::InvalidArgumentError(
        absl::StrCat("--minutes: expected > 0, found ", options.minutes));
  }
  SINEW_RETURN_IF_ERROR(CheckClip(options));
  SINEW_ASSIGN_OR_RETURN(
      const std::string clip,
      FindResource(absl::StrCat("pybullet_data/pybullet_data/data/motions/",
                                options.clip, ".txt")));
  SINEW_RETURN_IF_ERROR(MakeDirectories(options.out));
  const absl::Duration patience = kPatience + absl::Minutes(options.minutes);
  int number = 0;
  for (const Step& step : LearningSteps(options, clip)) {
    SINEW_RETURN_IF_ERROR(RunStep(step, ++number, patience, stop));
  }
  for (const Step& step : ShowingSteps(options)) {
    SINEW_RETURN_IF_ERROR(RunStep(step, ++number, patience, stop));
  }
  absl::FPrintF(stderr, "\nDone. Open %s in a browser.\n",
                JoinPath(options.out, "report.html"));
  return absl::OkStatus();
}

}  // namespace

void AddQuickstartCommand(CLI::App& app, Action& action) {
  auto options = std::make_shared<QuickstartOptions>();
  auto* command = AddSubcommand<QuickstartOptions>(
      app, "quickstart", "from a recorded clip to a report, in one go", options,
      action, RunQuickstart);
  command->add_option("--out", options->out, "folder of the run")
      ->capture_default_str();
  command->add_option("--clip", options->clip, "clip of the pybullet wheel")
      ->capture_default_str();
  command
      ->add_option("--minutes", options->minutes,
                   "of training, those of an earlier call included")
      ->check(FiniteRange(0, 1e6))
      ->capture_default_str();
  command->add_option("--seed", options->seed, "seed of all random streams")
      ->capture_default_str();
}

}  // namespace sinew::tools
