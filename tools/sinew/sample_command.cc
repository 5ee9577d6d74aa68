#include "tools/sinew/sample_command.h"

#include <cstdio>
#include <memory>
#include <string>

#include "absl/strings/str_format.h"
#include "common/cpu.h"
#include "common/status_macros.h"
#include "tools/sampling/sample_bundle.h"
#include "tools/sampling/sampling_json.h"
#include "tools/sinew/finite_range.h"

namespace sinew::tools {
namespace {

absl::Status RunSample(const sampling::SamplingOptions& asked,
                       const StopToken& stop) {
  sampling::SamplingOptions options = asked;
  if (options.threads == 0) options.threads = AvailableCpus();
  SINEW_ASSIGN_OR_RETURN(const sampling::SamplingResult result,
                         sampling::SampleBundle(options, stop));
  absl::PrintF("%s", sampling::SamplingTable(result.ways));
  for (const std::string& file : result.files) absl::PrintF("%s\n", file);
  return absl::OkStatus();
}

}  // namespace

void AddSampleCommand(CLI::App& app, Action& action) {
  auto options = std::make_shared<sampling::SamplingOptions>();
  options->threads = 0;  // all cores
  auto* command = AddSubcommand<sampling::SamplingOptions>(
      app, "sample", "the prior of a bundle alone moves the body", options,
      action, RunSample);
  command->add_option("--bundle", options->bundle, "folder, with a latent")
      ->required();
  CLI::Option* motions =
      command->add_option("--motions", options->motions,
                          "library: to start from, and to compare with");
  command->add_option("--out", options->out,
                      "JSON file (default: none, the table alone)");
  command
      ->add_option("--seconds", options->seconds,
                   "length of a sample (default 10)")
      ->check(FiniteRange(0, 1e6));
  command->add_option("--count", options->count,
                      "samples at each scale of the noise (default 64)");
  command->add_option("--per-start", options->per_start,
                      "samples of one start (default 4, if it divides)");
  command
      ->add_option("--noise", options->noise,
                   "scales of the prior's standard deviation (default 1)")
      ->check(FiniteRange(0, sampling::kMostNoise));
  command->add_option(
      "--start", options->start,
      "clip (upright frames), standing (those whose root hardly "
      "moves), fallen or CLIP:SECONDS (default: clip; without "
      "--motions fallen)");
  command->add_option("--seed", options->seed,
                      "seed of the noise and of which frames of clips are "
                      "starts; fallen starts are always the same (default 0)");
  command
      ->add_option("--threads", options->threads,
                   "threads (default: all cores)")
      ->check(ThreadRange());
  command
      ->add_option("--threshold", options->threshold,
                   "of coverage, standard deviations (default 0.5)")
      ->check(FiniteRange(0, 1e6))
      ->needs(motions);
  command
      ->add_option("--transitions", options->transitions,
                   "how many are compared at most (default 40000)")
      ->needs(motions);
  command->add_flag("--student", options->student,
                    "also what the bundle's policy covers when it tracks");
  command->add_option("--pictures", options->pictures, "folder of film strips");
  command->add_option("--page", options->page,
                      "HTML file that plays samples side by side");
}

}  // namespace sinew::tools
