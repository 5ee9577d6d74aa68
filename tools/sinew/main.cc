// The command that users type; ./sinew builds and runs it.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_format.h"
#include "common/stop.h"
#include "grpc/grpc.h"
#include "tools/sinew/actor_command.h"
#include "tools/sinew/bench_command.h"
#include "tools/sinew/card_command.h"
#include "tools/sinew/checkpoint_command.h"
#include "tools/sinew/command.h"
#include "tools/sinew/curriculum_command.h"
#include "tools/sinew/eval_command.h"
#include "tools/sinew/export_command.h"
#include "tools/sinew/learner_command.h"
#include "tools/sinew/motion_command.h"
#include "tools/sinew/promote_command.h"
#include "tools/sinew/quickstart_command.h"
#include "tools/sinew/render_command.h"
#include "tools/sinew/replay_command.h"
#include "tools/sinew/report_command.h"
#include "tools/sinew/sample_command.h"
#include "tools/sinew/teacher_command.h"
#include "tools/sinew/train_command.h"
#include "tools/sinew/verify_command.h"

namespace {

// Exit codes: 0 done, 1 failed, 2 bad usage or configuration.
int ExitCode(const absl::Status& status) {
  if (status.ok()) return 0;
  absl::FPrintF(stderr, "sinew: %s\n", std::string(status.message()));
  return absl::IsInvalidArgument(status) || absl::IsNotFound(status) ? 2 : 1;
}

// The parser first says what is missing, which may be what was mistyped.
void PrintUnknown(const CLI::App& app) {
  for (const std::string& word : app.remaining(/*recurse=*/true)) {
    absl::FPrintF(stderr, "sinew: unknown here: %s\n", word);
  }
}

}  // namespace

int main(int argc, char** argv) {
  using namespace sinew::tools;  // NOLINT: a main
  CLI::App app("Sinew: motion priors from motion clips and a MuJoCo character");
  app.require_subcommand(1);
  Action action;
  AddActorCommand(app, action);
  AddBenchCommand(app, action);
  AddCardCommand(app, action);
  AddCheckpointCommand(app, action);
  AddCurriculumCommand(app, action);
  AddEvalCommand(app, action);
  AddExportCommand(app, action);
  AddLearnerCommand(app, action);
  AddMotionCommand(app, action);
  AddPromoteCommand(app, action);
  AddQuickstartCommand(app, action);
  AddRenderCommand(app, action);
  AddReplayCommand(app, action);
  AddReportCommand(app, action);
  AddSampleCommand(app, action);
  AddTeacherCommand(app, action);
  AddTrainCommand(app, action);
  AddVerifyCommand(app, action);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ExtrasError& error) {  // names them itself
    app.exit(error);
    return 2;
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error) == 0 ? 0 : 2;
    if (code != 0) PrintUnknown(app);
    return code;
  }
  // Held until the process ends: when the last channel goes, gRPC would wait up
  // to 10 s for its own poller.
  grpc_init();
  const auto signals = sinew::SignalStop::Install();
  if (!signals.ok()) return ExitCode(signals.status());
  return ExitCode(action((*signals)->token()));
}
