#ifndef SINEW_COMMON_RPC_TESTING_HELD_GRPC_H_
#define SINEW_COMMON_RPC_TESTING_HELD_GRPC_H_

#include "grpc/grpc.h"
#include "gtest/gtest.h"

namespace sinew::rpc {

// Keeps gRPC up from before the first test to the end of the process: whenever
// its last object goes, gRPC 1.51 takes its poller down and may wait 10 s for
// sockets that nobody polls any more. For tests that open and close servers:
//
//   [[maybe_unused]] const auto* const held_grpc =
//       ::testing::AddGlobalTestEnvironment(new rpc::HeldGrpc());
//
// Thread-safety: none. Ownership: GoogleTest's. Blocking: never. Errors: none.
class HeldGrpc : public ::testing::Environment {
 public:
  // Never given back, which would only move the wait to the end.
  void SetUp() override { grpc_init(); }
};

}  // namespace sinew::rpc

#endif  // SINEW_COMMON_RPC_TESTING_HELD_GRPC_H_
