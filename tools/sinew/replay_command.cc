#include "tools/sinew/replay_command.h"

#include <cstdint>
#include <memory>

#include "common/status_macros.h"
#include "replay/service/replay_server.h"
#include "tools/sinew/role_logger.h"
#include "tools/sinew/security_flags.h"

namespace sinew::tools {
namespace {

absl::Status RunReplayCommand(const replay::ReplayServer::Options& options,
                              const StopToken& stop) {
  SINEW_RETURN_IF_ERROR(LogAs("replay"));
  return replay::RunReplay(options, stop);
}

}  // namespace

void AddReplayCommand(CLI::App& app, Action& action) {
  using Options = replay::ReplayServer::Options;
  auto options = std::make_shared<Options>();
  CLI::App* command = AddSubcommand<Options>(
      app, "replay", "hold segments between actors and a learner", options,
      action, RunReplayCommand);
  command
      ->add_option("--listen", options->address,
                   "HOST:PORT or unix:PATH; port 0 takes a free one")
      ->required();
  command
      ->add_option("--bytes", options->limit_bytes,
                   "bound of the table, e.g. 256MiB")
      ->transform(CLI::AsSizeValue(/*kb_is_1000=*/true))
      ->capture_default_str();
  command->add_option("--metrics", options->metrics_address,
                      "HOST:PORT for Prometheus; default: none");
  AddSecurityFlags(*command, options->security);
}

}  // namespace sinew::tools
