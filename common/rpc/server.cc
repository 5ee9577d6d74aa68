#include "common/rpc/server.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "common/rpc/address.h"
#include "common/rpc/channel.h"
#include "common/status_macros.h"
#include "grpcpp/health_check_service_interface.h"
#include "grpcpp/resource_quota.h"
#include "grpcpp/server_builder.h"

namespace sinew::rpc {
namespace {

// True if somebody accepts connections at a unix socket. gRPC would silently
// replace the socket of a living server.
bool SomebodyListens(const std::string& path) {
  const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return false;
  sockaddr_un name = {};
  name.sun_family = AF_UNIX;
  std::memcpy(name.sun_path, path.data(),
              std::min(path.size(), sizeof(name.sun_path) - 1));
  const int result =
      connect(fd, reinterpret_cast<const sockaddr*>(&name), sizeof(name));
  close(fd);
  return result == 0;
}

absl::Status InUse(const Address& address) {
  return absl::AlreadyExistsError(absl::StrCat(
      "cannot listen on ", AddressString(address),
      address.is_unix() ? ": another process does, or the folder is missing"
                        : ": the port is in use or the address is not ours"));
}

void Configure(const Server::Options& options, grpc::ServerBuilder& builder) {
  grpc::ResourceQuota quota("sinew");
  quota.SetMaxThreads(options.max_threads);
  builder.SetResourceQuota(quota);
  builder.SetMaxReceiveMessageSize(kMaxMessageBytes);
  builder.SetMaxSendMessageSize(kMaxMessageBytes);
  // Otherwise two servers may share a port without noticing.
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
  builder.AddChannelArgument(
      GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 15'000);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MAX_PING_STRIKES, 0);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, 30'000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 10'000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
}

}  // namespace

absl::StatusOr<std::unique_ptr<Server>> Server::Start(
    const Options& options, absl::Span<grpc::Service* const> services) {
  SINEW_ASSIGN_OR_RETURN(Address address, ParseAddress(options.address));
  SINEW_ASSIGN_OR_RETURN(const auto credentials,
                         MakeServerCredentials(address, options.security));
  if (address.is_unix() && SomebodyListens(address.unix_path)) {
    return InUse(address);
  }
  grpc::EnableDefaultHealthCheckService(true);
  grpc::ServerBuilder builder;
  Configure(options, builder);
  int port = 0;
  builder.AddListeningPort(AddressString(address), credentials, &port);
  for (grpc::Service* service : services) builder.RegisterService(service);
  std::unique_ptr<grpc::Server> server = builder.BuildAndStart();
  if (server == nullptr || port == 0) return InUse(address);
  if (!address.is_unix()) address.port = port;
  return std::unique_ptr<Server>(
      new Server(AddressString(address), std::move(server)));
}

Server::Server(std::string address, std::unique_ptr<grpc::Server> server)
    : address_(std::move(address)), server_(std::move(server)) {}

Server::~Server() { Shutdown(absl::ZeroDuration()); }

void Server::Drain() {
  grpc::HealthCheckServiceInterface* health = server_->GetHealthCheckService();
  if (health != nullptr) health->SetServingStatus(false);
}

void Server::Shutdown(absl::Duration timeout) {
  Drain();
  server_->Shutdown(absl::ToChronoTime(absl::Now() + timeout));
  server_->Wait();
}

}  // namespace sinew::rpc
