#ifndef SINEW_COMMON_RPC_SERVER_H_
#define SINEW_COMMON_RPC_SERVER_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "absl/types/span.h"
#include "common/rpc/credentials.h"
#include "grpcpp/impl/codegen/service_type.h"
#include "grpcpp/server.h"

namespace sinew::rpc {

// A listening gRPC server of one role: address, credentials, message limits,
// health service (grpc.health.v1; empty service name), orderly end.
//
//   Start -> SERVING -> Drain -> NOT_SERVING -> Shutdown(deadline)
//
// Handlers run on gRPC's threads. A handler that waits checks its context's
// IsCancelled, or a stop of its service, at least every 100 ms, so that
// Shutdown ends on time.
//
// Thread-safety: any thread. Ownership: borrows the services, which must
// outlive it. Blocking: Shutdown, until handlers are done, at most its
// deadline plus the handlers' reaction to cancellation. Errors: Start.
class Server {
 public:
  struct Options {
    // "unix:PATH" or "HOST:PORT"; port 0 takes a free one.
    std::string address;
    Security security = {};
    // Threads that serve calls, streams included, >= 8.
    int max_threads = 1024;
  };

  // ALREADY_EXISTS: the port or socket is in use (named); INVALID_ARGUMENT and
  // FAILED_PRECONDITION as ParseAddress and MakeServerCredentials.
  static absl::StatusOr<std::unique_ptr<Server>> Start(
      const Options& options, absl::Span<grpc::Service* const> services);

  // Shuts down at once if that has not happened.
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  // Where it listens, with the port that was taken.
  const std::string& address() const { return address_; }

  // Health becomes NOT_SERVING; calls still work. For readiness probes.
  void Drain();

  // Drains, refuses new calls, waits up to `timeout` for running ones, then
  // cancels them. May be called again; only the first call has an effect.
  void Shutdown(absl::Duration timeout);

 private:
  Server(std::string address, std::unique_ptr<grpc::Server> server);

  const std::string address_;
  const std::unique_ptr<grpc::Server> server_;
};

}  // namespace sinew::rpc

#endif  // SINEW_COMMON_RPC_SERVER_H_
