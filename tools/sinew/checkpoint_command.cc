#include "tools/sinew/checkpoint_command.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/time/time.h"
#include "common/build_info.h"
#include "common/clock.h"
#include "common/logging.h"
#include "common/rpc/credentials.h"
#include "common/status_context.h"
#include "common/status_macros.h"
#include "common/stop.h"
#include "deploy/checkpoint/client/artifact_store.h"
#include "deploy/checkpoint/folder_files.h"
#include "deploy/checkpoint/open_store.h"
#include "deploy/checkpoint/service/checkpoint_server.h"
#include "deploy/checkpoint/stable_bundle.h"
#include "tools/sinew/role_logger.h"
#include "tools/sinew/security_flags.h"

namespace sinew::tools {
namespace {

using checkpoint::ArtifactStore;
using checkpoint::StoreAccess;

constexpr absl::Duration kShutdown = absl::Seconds(20);

struct ServeOptions {
  std::string listen;
  std::string folder;
  std::string metrics;
  rpc::Security security;
};

// What the other verbs are given; each uses some of it.
struct StoreOptions {
  std::string store;
  rpc::Security security;
  std::string name;    // id or alias
  std::string folder;  // to read or to make
  std::string kind;
  std::string id;
  std::string expected;
  int64_t iteration = 0;
};

absl::Status Serve(const ServeOptions& options, const StopToken& stop) {
  SINEW_RETURN_IF_ERROR(LogAs("checkpoint"));
  const SystemClock clock;
  SINEW_ASSIGN_OR_RETURN(
      const auto server,
      checkpoint::CheckpointServer::Start({.address = options.listen,
                                           .folder = options.folder,
                                           .metrics_address = options.metrics,
                                           .security = options.security,
                                           .build = BuildIdentity()},
                                          clock));
  LogInfo("serving checkpoints", {{"folder", options.folder},
                                  {"address", server->address()},
                                  {"metrics", server->metrics_address()}});
  AwaitStop(stop);
  server->Shutdown(kShutdown);
  LogInfo("ended");
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<ArtifactStore>> Open(const StoreOptions& options,
                                                    StoreAccess access,
                                                    const StopToken& stop) {
  static const SystemClock clock;
  return checkpoint::OpenStore(options.store, access, options.security, clock,
                               stop);
}

void PrintArtifact(const v1::Artifact& artifact,
                   const v1::ListArtifactsResponse& list) {
  int64_t bytes = 0;
  for (const v1::Artifact::File& file : artifact.files()) bytes += file.size();
  std::vector<std::string> aliases;
  for (const v1::Alias& alias : list.aliases()) {
    if (alias.id() == artifact.id()) aliases.push_back(alias.name());
  }
  const std::string created = absl::FormatTime(
      "%Y-%m-%dT%H:%M:%SZ", absl::FromUnixSeconds(artifact.created_unix_s()),
      absl::UTCTimeZone());
  absl::PrintF("%-24s %-8s %9d %5d %10.2f %-20s %s\n", artifact.id(),
               artifact.kind(), artifact.iteration(), artifact.files_size(),
               static_cast<double>(bytes) / 1e6, created,
               absl::StrJoin(aliases, " "));
}

absl::Status List(const StoreOptions& options, const StopToken& stop) {
  SINEW_ASSIGN_OR_RETURN(const auto store,
                         Open(options, StoreAccess::kRead, stop));
  SINEW_ASSIGN_OR_RETURN(const v1::ListArtifactsResponse list,
                         store->ListArtifacts(options.kind));
  absl::PrintF("%-24s %-8s %9s %5s %10s %-20s %s\n", "id", "kind", "iteration",
               "files", "MB", "created", "aliases");
  for (const v1::Artifact& artifact : list.artifacts()) {
    PrintArtifact(artifact, list);
  }
  for (const std::string& damaged : list.damaged()) {
    LogWarning("damaged record", {{"reason", damaged}});
  }
  return absl::OkStatus();
}

absl::Status Get(const StoreOptions& options, const StopToken& stop) {
  SINEW_ASSIGN_OR_RETURN(const auto store,
                         Open(options, StoreAccess::kRead, stop));
  SINEW_ASSIGN_OR_RETURN(const checkpoint::ArtifactFiles files,
                         GetFiles(*store, options.name));
  SINEW_RETURN_IF_ERROR(checkpoint::WriteFolder(files, options.folder));
  absl::PrintF("%s: %d files of %s\n", options.folder, files.size(),
               options.name);
  return absl::OkStatus();
}

// Refuses the aliases that promotion owns.
absl::Status CheckNotPromotions(const std::string& name) {
  if (name != checkpoint::kStable && name != checkpoint::kStablePrevious) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "\"", name,
      "\": expected another name: this one is sinew promote's, which compares "
      "the bundle with the stable one (whatever the figures: with "
      "--success-tolerance 1 --error-tolerance 1e6) and keeps the way back "
      "(--rollback)"));
}

absl::Status Put(const StoreOptions& options, const StopToken& stop) {
  SINEW_RETURN_IF_ERROR(
      WithContext(checkpoint::CheckArtifactId(options.id), "--id"));
  SINEW_ASSIGN_OR_RETURN(const checkpoint::ArtifactFiles files,
                         checkpoint::ReadFolder(options.folder));
  SINEW_ASSIGN_OR_RETURN(const auto store,
                         Open(options, StoreAccess::kWrite, stop));
  v1::Artifact record;
  record.set_id(options.id);
  record.set_kind(options.kind);
  record.set_iteration(options.iteration);
  SINEW_RETURN_IF_ERROR(PutFiles(*store, record, files));
  absl::PrintF("%s: %d files of %s\n", options.id, files.size(),
               options.folder);
  return absl::OkStatus();
}

absl::Status SetAlias(const StoreOptions& options, const StopToken& stop) {
  SINEW_RETURN_IF_ERROR(CheckNotPromotions(options.name));
  SINEW_ASSIGN_OR_RETURN(const auto store,
                         Open(options, StoreAccess::kWrite, stop));
  SINEW_RETURN_IF_ERROR(
      store->SetAlias(options.name, options.id, options.expected));
  absl::PrintF("%s -> %s\n", options.name, options.id);
  return absl::OkStatus();
}

void AddServe(CLI::App& app, Action& action) {
  auto options = std::make_shared<ServeOptions>();
  CLI::App* command = AddSubcommand<ServeOptions>(
      app, "serve", "serve a folder's store", options, action, Serve);
  command
      ->add_option("--listen", options->listen,
                   "HOST:PORT or unix:PATH; port 0: a free one")
      ->required();
  command->add_option("--folder", options->folder, "made if need be")
      ->required();
  command->add_option("--metrics", options->metrics,
                      "HOST:PORT for Prometheus; default: none");
  AddSecurityFlags(*command, options->security);
}

// A verb with the options that all of them share.
CLI::App* AddVerb(CLI::App& app, Action& action, const std::string& name,
                  const std::string& description,
                  const std::shared_ptr<StoreOptions>& options,
                  absl::Status (*run)(const StoreOptions&, const StopToken&)) {
  CLI::App* command =
      AddSubcommand<StoreOptions>(app, name, description, options, action, run);
  command
      ->add_option("--store", options->store,
                   "a folder, or a service at HOST:PORT or unix:PATH")
      ->required();
  AddSecurityFlags(*command, options->security);
  return command;
}

}  // namespace

void AddCheckpointCommand(CLI::App& app, Action& action) {
  auto* checkpoint =
      app.add_subcommand("checkpoint", "training states, bundles and assets");
  checkpoint->require_subcommand(1);
  AddServe(*checkpoint, action);

  auto options = std::make_shared<StoreOptions>();
  AddVerb(*checkpoint, action, "list", "artifacts, newest first", options, List)
      ->add_option("--kind", options->kind, "state, bundle, assets ...");

  CLI::App* get = AddVerb(*checkpoint, action, "get",
                          "an artifact's files to a new folder", options, Get);
  get->add_option("name", options->name, "id or alias")->required();
  get->add_option("--out", options->folder, "the folder")->required();

  CLI::App* put = AddVerb(*checkpoint, action, "put",
                          "a folder's files as a new artifact", options, Put);
  put->add_option("folder", options->folder, "the folder")->required();
  put->add_option("--id", options->id, "[A-Za-z0-9._-]")->required();
  put->add_option("--kind", options->kind, "state, bundle, assets ...")
      ->required();
  put->add_option("--iteration", options->iteration, "that it was made at");

  CLI::App* alias = AddVerb(*checkpoint, action, "alias",
                            "point a name at an artifact; sinew promote does "
                            "so with stable",
                            options, SetAlias);
  alias->add_option("name", options->name, "the alias")->required();
  alias->add_option("id", options->id, "of the artifact")->required();
  alias->add_option("--expected", options->expected,
                    "refuse unless it points there now");
}

}  // namespace sinew::tools
