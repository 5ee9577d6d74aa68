#include "tools/sinew/export_command.h"

#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/string_view.h"
#include "common/clock.h"
#include "common/files.h"
#include "common/rpc/credentials.h"
#include "common/status_context.h"
#include "common/status_macros.h"
#include "deploy/bundle/run_export.h"
#include "deploy/checkpoint/client/artifact_store.h"
#include "deploy/checkpoint/open_store.h"
#include "learner/state/newest_state.h"
#include "learner/state/state_store.h"
#include "proto/sinew/v1/run.pb.h"
#include "tools/sinew/security_flags.h"
#include "tools/training/compact_state.h"
#include "tools/training/shown_folder.h"

namespace sinew::tools {
namespace {

struct ExportOptions {
  std::string run;
  std::string out;
  std::string state;
  bool best = false;
  std::string checkpoint;  // empty: RUN/checkpoints
  rpc::Security security;
};

// Where the run's states are.
std::string StoreOf(const ExportOptions& options) {
  return options.checkpoint.empty() ? JoinPath(options.run, "checkpoints")
                                    : options.checkpoint;
}

// Whether what is to be exported was trained on the library that the run now
// has; `what` names it. `now` or `found` unset: not known.
absl::Status CheckAssets(const ExportOptions& options, absl::string_view what,
                         const std::string& now, const std::string& found) {
  if (now.empty() || found.empty() || now == found) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat(
      options.run, ": ", what, ": expected one of the run's assets ", now,
      ", found one of ", found, "; train on with the library of now"));
}

absl::Status ExportLatest(const ExportOptions& options,
                          checkpoint::ArtifactStore& store) {
  SINEW_ASSIGN_OR_RETURN(const v1::RunInputs inputs,
                         bundle::ReadRunInputs(options.run));
  std::vector<std::string> warnings;
  const auto state = learner::LoadLatestState(store, &warnings);
  for (const std::string& warning : warnings) {
    absl::FPrintF(stderr, "sinew: %s\n", warning);
  }
  SINEW_RETURN_IF_ERROR(WithContext(state.status(), StoreOf(options)));
  if (state->snapshots.empty()) {
    return absl::DataLossError(
        absl::StrCat(options.run, ": expected a snapshot in state ",
                     state->counters.iteration(), ", found none"));
  }
  const v1::TrainingState& counters = state->counters;
  SINEW_RETURN_IF_ERROR(CheckAssets(options, "the newest state",
                                    inputs.assets_sha256(),
                                    counters.assets_sha256()));
  return bundle::ExportRun(
      options.run,
      {.snapshot = state->snapshots.back(),
       .iterations = counters.iteration(),
       .samples = counters.samples(),
       .train_seconds = counters.train_seconds(),
       .build = counters.build(),
       .metrics = counters.has_metrics() ? std::optional(counters.metrics())
                                         : std::nullopt},
      options.out);
}

// What the run's assets are now: its inputs say so, or, in a run of old, its
// newest state; empty if neither does.
absl::StatusOr<std::string> AssetsNow(const ExportOptions& options,
                                      checkpoint::ArtifactStore& store) {
  SINEW_ASSIGN_OR_RETURN(const v1::RunInputs inputs,
                         bundle::ReadRunInputs(options.run));
  if (!inputs.assets_sha256().empty()) return inputs.assets_sha256();
  std::vector<std::string> warnings;
  const auto state = learner::LoadLatestCounters(store, &warnings);
  if (absl::IsNotFound(state.status())) return "";
  SINEW_RETURN_IF_ERROR(state.status());
  return state->assets_sha256();
}

absl::Status ExportBest(const ExportOptions& options,
                        checkpoint::ArtifactStore& store) {
  SINEW_ASSIGN_OR_RETURN(const checkpoint::ArtifactFiles files,
                         GetFiles(store, checkpoint::kBest));
  const auto snapshot = files.find("snapshot");
  const auto record = files.find("evaluated.pb");
  v1::EvaluatedPolicy evaluated;
  if (snapshot == files.end() || record == files.end() ||
      !evaluated.ParseFromString(*record->second)) {
    return absl::DataLossError(
        absl::StrCat(options.run,
                     ": artifact \"best\": expected files snapshot and "
                     "evaluated.pb, found ",
                     files.size(), " others"));
  }
  SINEW_ASSIGN_OR_RETURN(const std::string now, AssetsNow(options, store));
  SINEW_RETURN_IF_ERROR(
      CheckAssets(options, "the best policy", now, evaluated.assets_sha256()));
  return bundle::ExportRun(options.run,
                           {.snapshot = *snapshot->second,
                            .iterations = evaluated.iteration(),
                            .samples = evaluated.samples(),
                            .train_seconds = evaluated.train_seconds(),
                            .build = evaluated.build(),
                            .metrics = evaluated.metrics()},
                           options.out);
}

absl::Status CheckOptions(const ExportOptions& options) {
  if (options.out.empty() == options.state.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("--out, --state: expected one of them, found ",
                     options.out.empty() ? "none" : "both"));
  }
  if (options.best && !options.state.empty()) {
    return absl::InvalidArgumentError(
        "--best: expected --out, found --state, which is of the newest state");
  }
  return absl::OkStatus();
}

// A store that the user names may be another run's.
absl::Status CheckStoreIsOf(const ExportOptions& options,
                            const v1::RunInputs& inputs,
                            checkpoint::ArtifactStore& store) {
  if (options.checkpoint.empty()) return absl::OkStatus();
  std::vector<std::string> warnings;
  const auto counters = learner::LoadLatestCounters(store, &warnings);
  SINEW_RETURN_IF_ERROR(counters.status());
  return CheckAssets(options, "the newest state", inputs.assets_sha256(),
                     counters->assets_sha256());
}

absl::Status ExportState(const ExportOptions& options,
                         checkpoint::ArtifactStore& store, const Clock& clock) {
  SINEW_ASSIGN_OR_RETURN(const v1::RunInputs inputs,
                         bundle::ReadRunInputs(options.run));
  SINEW_RETURN_IF_ERROR(
      WithContext(CheckStoreIsOf(options, inputs, store), StoreOf(options)));
  const std::vector<v1::RunInputs::Source> sources(inputs.sources().begin(),
                                                   inputs.sources().end());
  return WriteCompactState(store, options.state, clock, sources);
}

absl::Status RunExport(const ExportOptions& asked, const StopToken& stop) {
  SINEW_RETURN_IF_ERROR(CheckOptions(asked));
  ExportOptions options = asked;
  SINEW_ASSIGN_OR_RETURN(options.run, FolderToExport(asked.run));
  if (options.checkpoint.empty() && !FileExists(StoreOf(options))) {
    return absl::NotFoundError(absl::StrCat(
        options.run,
        ": expected a run directory, found no checkpoints/ (of a learner with "
        "--checkpoint they are there: give the same --checkpoint)"));
  }
  const SystemClock clock;
  SINEW_ASSIGN_OR_RETURN(
      const auto store,
      checkpoint::OpenStore(StoreOf(options), checkpoint::StoreAccess::kRead,
                            options.security, clock, stop));
  if (!options.state.empty()) {
    SINEW_RETURN_IF_ERROR(ExportState(options, *store, clock));
  } else {
    SINEW_RETURN_IF_ERROR(options.best ? ExportBest(options, *store)
                                       : ExportLatest(options, *store));
  }
  absl::PrintF("%s\n", options.state.empty() ? options.out : options.state);
  return absl::OkStatus();
}

}  // namespace

void AddExportCommand(CLI::App& app, Action& action) {
  auto options = std::make_shared<ExportOptions>();
  auto* command = AddSubcommand<ExportOptions>(
      app, "export", "a bundle from a run, or a compact state", options, action,
      RunExport);
  command->add_option("--run", options->run, "run directory")->required();
  command->add_option("--out", options->out,
                      "bundle folder to write (this or --state)");
  command->add_option("--state", options->state,
                      "instead: a new folder with what another machine needs "
                      "to train on (sinew train --continue)");
  command->add_flag("--best", options->best,
                    "the best evaluated policy instead of the newest state");
  command->add_option(
      "--checkpoint", options->checkpoint,
      "where the learner keeps its states: a checkpoint service "
      "or a folder; default: in the run directory");
  AddSecurityFlags(*command, options->security);
}

}  // namespace sinew::tools
