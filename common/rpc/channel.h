#ifndef SINEW_COMMON_RPC_CHANNEL_H_
#define SINEW_COMMON_RPC_CHANNEL_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "common/rpc/credentials.h"
#include "grpcpp/channel.h"
#include "grpcpp/client_context.h"

namespace sinew::rpc {

// Largest message that either side sends or takes. Payloads travel in chunks
// (chunks.h); only lists of orders and artifacts come near it.
inline constexpr int kMaxMessageBytes = 16 << 20;

// A channel to one peer. It connects lazily and reconnects by itself with
// back-off; keep-alive pings notice a dead peer within 40 s. Errors as
// ParseAddress and MakeChannelCredentials. Never blocks on the network.
absl::StatusOr<std::shared_ptr<grpc::Channel>> MakeChannel(
    const std::string& address, const Security& security);

// Every call gets a deadline: `timeout` from now.
void SetTimeout(grpc::ClientContext& context, absl::Duration timeout);

}  // namespace sinew::rpc

#endif  // SINEW_COMMON_RPC_CHANNEL_H_
