#ifndef SINEW_COMMON_RPC_PEER_CALLS_H_
#define SINEW_COMMON_RPC_PEER_CALLS_H_

#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "common/rpc/retry.h"
#include "grpcpp/channel.h"

namespace sinew::rpc {

// Calls to a peer that may not be there yet, or may be away for a while. gRPC
// connects only while somebody waits on the channel, and fails calls at once
// while it is not connected; so back-off alone never finds a peer that has
// come up meanwhile. Each attempt here first waits for the connection:
//
//   connected:            the attempt; if it fails for now, back off, again
//   no connection within  one attempt, which fails and says why, and no more
//     connect_timeout:
//
// Thread-safety: any thread. Ownership: shares the channel. Blocking: at most
// connect_timeout for a peer that is not there, plus the attempt; otherwise as
// long as attempts and back-off last. After `stop` within 100 ms plus the
// attempt's own reaction. Errors: as Retry.
class PeerCalls {
 public:
  struct Options {
    // Says who the peer is in the log.
    std::string peer = {};
    absl::Duration connect_timeout = absl::Seconds(15);
    BackoffOptions backoff = {};
    std::stop_token stop = {};
  };

  PeerCalls(std::shared_ptr<grpc::Channel> channel, Options options)
      : channel_(std::move(channel)), options_(std::move(options)) {}

  // As Retry, at most `max_attempts` times; `attempt` has a deadline and ends
  // on `stop`.
  absl::Status Run(int max_attempts,
                   const std::function<absl::Status()>& attempt) const;

 private:
  // False: not within connect_timeout, or stopped.
  bool AwaitConnection() const;

  const std::shared_ptr<grpc::Channel> channel_;
  const Options options_;
};

}  // namespace sinew::rpc

#endif  // SINEW_COMMON_RPC_PEER_CALLS_H_
