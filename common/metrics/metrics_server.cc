#include "common/metrics/metrics_server.h"

#include <exception>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/rpc/address.h"
#include "common/status_macros.h"
#include "prometheus/exposer.h"

namespace sinew::metrics {

absl::StatusOr<std::unique_ptr<MetricsServer>> MetricsServer::Start(
    const std::string& address, const Registry& registry) {
  SINEW_ASSIGN_OR_RETURN(rpc::Address parsed, rpc::ParseAddress(address));
  if (parsed.is_unix()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "metrics address: expected HOST:PORT, found \"", address, "\""));
  }
  std::unique_ptr<prometheus::Exposer> exposer;
  // The library below reports a failure to listen by an exception.
  try {
    exposer = std::make_unique<prometheus::Exposer>(std::vector<std::string>{
        "listening_ports", rpc::AddressString(parsed), "num_threads", "2"});
  } catch (const std::exception& error) {
    return absl::AlreadyExistsError(
        absl::StrCat("cannot serve metrics on ", address,
                     ": the port is in use or the address is not ours (",
                     error.what(), ")"));
  }
  for (const auto& collectable : registry.collectables()) {
    exposer->RegisterCollectable(collectable);
  }
  parsed.port = exposer->GetListeningPorts().front();
  return std::unique_ptr<MetricsServer>(
      new MetricsServer(rpc::AddressString(parsed), std::move(exposer)));
}

MetricsServer::MetricsServer(std::string address,
                             std::unique_ptr<prometheus::Exposer> exposer)
    : address_(std::move(address)), exposer_(std::move(exposer)) {}

MetricsServer::~MetricsServer() = default;

}  // namespace sinew::metrics
