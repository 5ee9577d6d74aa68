#include "tools/sinew/eval_command.h"

#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "common/cpu.h"
#include "common/evaluation/evaluation_summary.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "tools/evaluation/evaluate_bundle.h"
#include "tools/evaluation/fallen_figures.h"
#include "tools/evaluation/figures_table.h"
#include "tools/sinew/finite_range.h"

namespace sinew::tools {
namespace {

struct EvalOptions {
  std::string bundle;
  std::string motions;
  std::string out;
  double seconds = 10;
  int starts = 32;
  int threads = 0;  // 0: all cores
  std::optional<int> fallen;
  std::optional<double> max_mean_body_distance;
  std::vector<std::string> table;  // NAME=FILE
};

// A mean over `frames`; of none it is not 0, the best there is.
std::string Mean(int64_t frames, const std::string& text) {
  return frames > 0 ? text : "-";
}

void Print(const char* who, const SetSummary& set) {
  const MetricMeans& means = set.means;
  absl::PrintF(
      "%-12s %d of %d clips (%d from their first frame), %d of %d starts, "
      "survived %.0f %%, E_g %s, E %s, E_vel %s, E_acc %s\n",
      who, set.succeeded_clips, set.clips, set.first_start_successes,
      set.succeeded_starts, set.starts, 100 * set.survived_share,
      Mean(set.frames, absl::StrFormat("%.1f mm", means.e_g_mpjpe_mm)),
      Mean(set.frames, absl::StrFormat("%.1f mm", means.e_mpjpe_mm)),
      Mean(means.velocity_frames,
           absl::StrFormat("%.2f mm/frame", means.e_vel)),
      Mean(means.acceleration_frames,
           absl::StrFormat("%.2f mm/frame^2", means.e_acc)));
}

void PrintRecovered(const char* name, int starts,
                    const evaluation::FallenFigures& policy,
                    const evaluation::FallenFigures& zero_action) {
  absl::PrintF(
      "%-12s %d starts, stand and track again within 3 s: %.1f %%, within 5 s: "
      "%.1f %% (zero action: %.1f %%, %.1f %%)\n",
      name, starts, 100 * policy.recovered_3_s, 100 * policy.recovered_5_s,
      100 * zero_action.recovered_3_s, 100 * zero_action.recovered_5_s);
}

void PrintFallen(const evaluation::FallenEvaluation& fallen) {
  PrintRecovered("fallen", fallen.starts, fallen.policy, fallen.zero_action);
  if (!fallen.get_up) return;
  PrintRecovered("by get-up", fallen.starts, fallen.get_up->policy,
                 fallen.get_up->zero_action);
}

void PrintImported(const SetSummary& overall, int rejected) {
  const int clips = overall.clips + rejected;
  absl::PrintF(
      "%-12s %d of %d clips (%.1f %%); %d that the import turned away count as "
      "failed\n",
      "imported", overall.succeeded_clips, clips,
      clips > 0 ? 100.0 * overall.succeeded_clips / clips : 0.0, rejected);
}

absl::Status PrintTable(const std::vector<std::string>& files) {
  std::vector<evaluation::TableRow> rows;
  for (const std::string& one : files) {
    const std::pair<std::string, std::string> parts =
        absl::StrSplit(one, absl::MaxSplits('=', 1));
    if (parts.second.empty()) {
      return absl::InvalidArgumentError(
          absl::StrCat("--table: expected NAME=FILE, found ", one));
    }
    SINEW_ASSIGN_OR_RETURN(std::string json, ReadFile(parts.second));
    rows.push_back(
        {.name = parts.first, .file = parts.second, .json = std::move(json)});
  }
  SINEW_ASSIGN_OR_RETURN(const std::string table,
                         evaluation::FiguresTable(rows));
  absl::PrintF("%s", table);
  return absl::OkStatus();
}

absl::Status RunEval(const EvalOptions& options, const StopToken& stop) {
  if (!options.table.empty()) return PrintTable(options.table);
  for (const auto& [flag, value] : {std::pair("--bundle", options.bundle),
                                    std::pair("--motions", options.motions),
                                    std::pair("--out", options.out)}) {
    if (!value.empty()) continue;
    return absl::InvalidArgumentError(absl::StrCat(
        flag, ": expected a value (or --table alone), found none"));
  }
  SINEW_ASSIGN_OR_RETURN(
      const evaluation::EvaluationFigures figures,
      evaluation::EvaluateBundle(
          options.bundle, options.motions, options.out,
          {.starts = options.starts,
           .seconds = options.seconds,
           .threads = options.threads > 0 ? options.threads : AvailableCpus(),
           .fallen = options.fallen,
           .max_mean_body_distance = options.max_mean_body_distance},
          stop));
  Print("policy", figures.policy.overall);
  if (figures.policy.left_out.clips > 0) {
    Print("trained on", figures.policy.training);
    Print("left out", figures.policy.left_out);
  }
  Print("successful", figures.policy.successful);
  Print("zero action", figures.zero_action.overall);
  if (figures.rejected_clips) {
    PrintImported(figures.policy.overall, *figures.rejected_clips);
  }
  if (figures.fallen) PrintFallen(*figures.fallen);
  return absl::OkStatus();
}

}  // namespace

void AddEvalCommand(CLI::App& app, Action& action) {
  auto options = std::make_shared<EvalOptions>();
  auto* command = AddSubcommand<EvalOptions>(
      app, "eval", "the papers' metrics of a bundle, or a table of some",
      options, action, RunEval);
  command->add_option("--bundle", options->bundle,
                      "bundle folder (this, --motions and --out, or --table)");
  command->add_option("--motions", options->motions, "library to follow");
  command->add_option("--out", options->out, "JSON file to write");
  command
      ->add_option("--seconds", options->seconds,
                   "how long looping clips run on (default 10)")
      ->check(FiniteRange(0, 86400));
  command
      ->add_option("--starts", options->starts,
                   "evenly spaced phases per clip (default 32)")
      ->check(CLI::Range(1, 10000));
  command->add_option("--fallen", options->fallen,
                      "so many starts on the floor as well, 1 to 1024 (256 is "
                      "the usual figure)");
  command
      ->add_option("--max-mean-body-distance", options->max_mean_body_distance,
                   "metres beyond which a start fails (default: the "
                   "bundle's, of its recipe)")
      ->check(FiniteRange(0, 1e6));
  command
      ->add_option("--threads", options->threads,
                   "threads (default: all cores)")
      ->check(ThreadRange());
  CLI::Option* table =
      command->add_option("--table", options->table,
                          "nothing is evaluated: prints a table of such JSON "
                          "files, NAME=FILE each");
  for (const char* other :
       {"--bundle", "--motions", "--out", "--seconds", "--starts", "--fallen",
        "--max-mean-body-distance", "--threads"}) {
    table->excludes(command->get_option(other));
  }
}

}  // namespace sinew::tools
