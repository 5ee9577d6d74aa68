#include "replay/service/replay_server.h"

#include "absl/strings/str_cat.h"
#include "common/build_info.h"
#include "common/logging.h"
#include "common/status_macros.h"

namespace sinew::replay {
namespace {

constexpr int64_t kLeastBytes = 1 << 20;
constexpr absl::Duration kFarewell = absl::Seconds(5);

}  // namespace

ReplayServer::ReplayServer(const Options& options)
    : registry_({.role = "replay", .build = BuildIdentity()}),
      metrics_(registry_),
      table_({.limit_bytes = options.limit_bytes}, metrics_),
      service_(table_) {}

absl::StatusOr<std::unique_ptr<ReplayServer>> ReplayServer::Create(
    const Options& options) {
  if (options.limit_bytes < kLeastBytes) {
    return absl::InvalidArgumentError(
        absl::StrCat("bytes: expected >= ", kLeastBytes, " (1 MiB), found ",
                     options.limit_bytes));
  }
  std::unique_ptr<ReplayServer> result(new ReplayServer(options));
  if (!options.metrics_address.empty()) {
    SINEW_ASSIGN_OR_RETURN(result->metrics_server_,
                           metrics::MetricsServer::Start(
                               options.metrics_address, result->registry_));
  }
  SINEW_ASSIGN_OR_RETURN(result->server_,
                         rpc::Server::Start({.address = options.address,
                                             .security = options.security},
                                            {&result->service_}));
  return result;
}

ReplayServer::~ReplayServer() { Shutdown(absl::Seconds(1)); }

std::string ReplayServer::metrics_address() const {
  return metrics_server_ == nullptr ? "" : metrics_server_->address();
}

void ReplayServer::Shutdown(absl::Duration timeout) {
  // Handlers that wait for room or for segments see this at once.
  table_.Close();
  if (server_ != nullptr) server_->Shutdown(timeout);
}

absl::Status RunReplay(const ReplayServer::Options& options,
                       const StopToken& stop) {
  SINEW_ASSIGN_OR_RETURN(const std::unique_ptr<ReplayServer> server,
                         ReplayServer::Create(options));
  LogInfo("serving replay", {{"address", server->address()},
                             {"limit_bytes", options.limit_bytes},
                             {"metrics", server->metrics_address()}});
  AwaitStop(stop);
  LogInfo("replay ends");
  server->Shutdown(kFarewell);
  return absl::OkStatus();
}

}  // namespace sinew::replay
