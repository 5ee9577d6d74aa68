#ifndef SINEW_COMMON_RPC_STATUS_H_
#define SINEW_COMMON_RPC_STATUS_H_

#include <string>

#include "absl/status/status.h"
#include "grpcpp/support/status.h"

namespace sinew::rpc {

// The same code and message in gRPC's type.
grpc::Status ToGrpc(const absl::Status& status);

// The same code; the message is preceded by `peer` ("dispatcher unix:/run/x")
// so that a reader knows who answered.
absl::Status FromGrpc(const grpc::Status& status, const std::string& peer);

// True for failures that say nothing about the request: the peer is away, was
// too slow, or is short of something for now.
bool IsTransient(const absl::Status& status);

}  // namespace sinew::rpc

#endif  // SINEW_COMMON_RPC_STATUS_H_
