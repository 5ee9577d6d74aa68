#include "tools/sinew/run_flags.h"

#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "common/cpu.h"
#include "common/status_macros.h"
#include "tools/sinew/finite_range.h"
#include "tools/sinew/resources.h"
#include "tools/sinew/security_flags.h"

namespace sinew::tools {

void AddRunFlags(CLI::App& command, RunFlags& flags) {
  command.add_option("--recipe", flags.recipe, "name of one, or a file")
      ->required();
  command.add_option("--motions", flags.motions, "library")->required();
  command.add_option("--run", flags.run, "run directory")->required();
  command.add_option("--character", flags.character, "name of one, or a file")
      ->capture_default_str();
  command
      .add_option("--minutes", flags.minutes,
                  "of training, those before it was resumed included")
      ->check(FiniteRange(0, 1e6));
  command
      .add_option("--iterations", flags.iterations,
                  "at which it ends, those before included")
      ->check(CLI::NonNegativeNumber);
  command.add_option("--seed", flags.seed, "seed of all random streams");
  command
      .add_option("--threads", flags.threads, "threads (default: all cores)")
      ->check(ThreadRange());
  command.add_option("--init", flags.init,
                     "bundle whose weights a new run begins with");
  command.add_option("--primitives", flags.primitives,
                     "bundles that the composer of a new run weighs, in order");
  command.add_option("--continue", flags.continue_from,
                     "compact state (sinew export --state) that a new run goes "
                     "on from");
  command.add_option(
      "--teacher", flags.teachers,
      "who labels a distillation: a bundle's folder, or addresses of `sinew "
      "teacher`, those of its replicas with commas between; of several "
      "bundles each labels the clips that it was trained on, the one of fewest "
      "clips first");
  command.add_option(
      "--teacher-eval", flags.teacher_evaluations,
      "files that `sinew eval --out` wrote, one of each of several bundles in "
      "--teacher, all of this library and with the same --starts: a clip's "
      "teacher is the one that wins most of them, then the one that survives "
      "longest, then the nearest");
  command
      .add_option("--teacher-patience", flags.teacher_patience,
                  "seconds to go on asking teachers elsewhere while none of "
                  "them answers")
      ->capture_default_str()
      ->check(FiniteRange(0.001, 1e6));
  command
      .add_option("--teacher-timeout", flags.teacher_timeout,
                  "seconds of one call to a teacher elsewhere, after which it "
                  "has failed; longer than its slowest answer")
      ->capture_default_str()
      ->check(FiniteRange(0.001, 1e6));
  command.add_flag("--migrate-library", flags.migrate_library,
                   "go on although the library has changed since the run "
                   "began; statistics of unchanged clips stay");
  command.add_option("--set", flags.set, "path=value in the recipe");
  AddSecurityFlags(command, flags.security);
}

int ThreadsOf(const RunFlags& flags) {
  return flags.threads > 0 ? flags.threads : AvailableCpus();
}

absl::StatusOr<TrainingRun::Options> MakeRunOptions(const RunFlags& flags) {
  std::vector<std::string> set = flags.set;
  if (flags.seed) set.push_back(absl::StrCat("seed=", *flags.seed));
  TrainingRun::Options options;
  SINEW_ASSIGN_OR_RETURN(options.recipe, LoadRecipe(flags.recipe, set));
  options.character = flags.character;
  options.motions = flags.motions;
  options.directory = flags.run;
  options.init = flags.init;
  options.primitives = flags.primitives;
  options.continue_from = flags.continue_from;
  options.teachers = flags.teachers;
  options.teacher_evaluations = flags.teacher_evaluations;
  options.teacher_patience = absl::Seconds(flags.teacher_patience);
  options.teacher_timeout = absl::Seconds(flags.teacher_timeout);
  options.migrate_library = flags.migrate_library;
  options.minutes = flags.minutes;
  options.iterations = flags.iterations;
  options.security = flags.security;
  options.cores = options.ranks = ThreadsOf(flags);
  return options;
}

}  // namespace sinew::tools
