#ifndef SINEW_COMMON_RPC_TESTING_REFUSED_CHANNEL_H_
#define SINEW_COMMON_RPC_TESTING_REFUSED_CHANNEL_H_

#include <memory>
#include <string>

#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "common/rpc/channel.h"
#include "grpcpp/channel.h"
#include "gtest/gtest.h"

namespace sinew::rpc {

// A channel to an address where nobody listens yet, once its first connection
// was refused: what a client has that was started before its server.
//
// Thread-safety: any thread. Blocking: until refused, at most 30 s (the test
// fails then). Errors: none.
inline std::shared_ptr<grpc::Channel> RefusedChannel(
    const std::string& address) {
  const std::shared_ptr<grpc::Channel> channel = *MakeChannel(address, {});
  const auto deadline = absl::ToChronoTime(absl::Now() + absl::Seconds(30));
  grpc_connectivity_state state = channel->GetState(/*try_to_connect=*/true);
  while (state != GRPC_CHANNEL_TRANSIENT_FAILURE) {
    if (!channel->WaitForStateChange(state, deadline)) {
      ADD_FAILURE() << address << ": expected to be refused, found " << state;
      break;
    }
    state = channel->GetState(/*try_to_connect=*/true);
  }
  return channel;
}

}  // namespace sinew::rpc

#endif  // SINEW_COMMON_RPC_TESTING_REFUSED_CHANNEL_H_
