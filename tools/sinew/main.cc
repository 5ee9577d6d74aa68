// The command that users type; ./sinew builds and runs it.

#include <CLI/CLI.hpp>
#include <cstdio>

#include "absl/status/status.h"
#include "absl/strings/str_format.h"
#include "common/stop_signal.h"
#include "tools/sinew/motion_command.h"
#include "tools/sinew/train_command.h"

namespace {

// Exit codes: 0 done, 1 failed, 2 bad usage or configuration.
int ExitCode(const absl::Status& status) {
  if (status.ok()) return 0;
  absl::FPrintF(stderr, "sinew: %s\n", std::string(status.message()));
  return absl::IsInvalidArgument(status) || absl::IsNotFound(status) ? 2 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace sinew::tools;  // NOLINT: a main
  CLI::App app("Sinew: motion priors from motion clips and a MuJoCo character");
  app.require_subcommand(1);

  auto* motion = app.add_subcommand("motion", "motion libraries");
  motion->require_subcommand(1);
  ImportOptions import;
  auto* importing = AddMotionImport(*motion, import);

  TrainOptions train;
  auto* training = app.add_subcommand("train", "start or resume a run");
  training->add_option("--recipe", train.recipe, "name or file")->required();
  training->add_option("--motions", train.motions, "library")->required();
  training->add_option("--run", train.run, "run directory")->required();
  training->add_option("--character", train.character, "name or file");
  training->add_option("--minutes", train.minutes, "of training, in all");
  training->add_option("--iterations", train.iterations, "in all");
  training->add_option("--seed", train.seed, "of all random streams");
  training->add_option("--threads", train.threads, "default: all cores");
  training->add_option("--set", train.set, "path=value in the recipe");

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  sinew::CatchStopSignals();
  if (importing->parsed()) return ExitCode(RunMotionImport(import));
  return ExitCode(RunTrain(train));
}
