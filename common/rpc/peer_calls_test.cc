#include "common/rpc/peer_calls.h"

#include <memory>
#include <stop_token>
#include <string>
#include <thread>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "common/rpc/channel.h"
#include "common/rpc/server.h"
#include "common/rpc/testing/held_grpc.h"
#include "common/rpc/testing/refused_channel.h"
#include "common/rpc/testing/socket_folder.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "grpcpp/channel.h"
#include "gtest/gtest.h"
#include "proto/sinew/v1/blob.grpc.pb.h"

namespace sinew::rpc {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;

[[maybe_unused]] const auto* const held_grpc =
    ::testing::AddGlobalTestEnvironment(new HeldGrpc());

class PeerCallsTest : public ::testing::Test {
 protected:
  PeerCallsTest() : channel_(RefusedChannel(address_)) {}

  // What a call says: gRPC itself knows whether it is connected.
  absl::Status Attempt() {
    ++attempts_;
    return channel_->GetState(/*try_to_connect=*/false) == GRPC_CHANNEL_READY
               ? absl::OkStatus()
               : absl::UnavailableError("peer: connection refused");
  }

  const SocketFolder folder_;
  v1::Blobs::Service service_;  // any
  const std::string address_ = folder_.Address("p");
  const std::shared_ptr<grpc::Channel> channel_;
  int attempts_ = 0;
};

TEST_F(PeerCallsTest, FindAPeerThatComesAfterItWasAskedFor) {
  const PeerCalls calls(channel_, {.connect_timeout = absl::Seconds(30)});
  const auto server = Server::Start({.address = address_}, {&service_});
  ASSERT_THAT(server, IsOk());

  EXPECT_THAT(calls.Run(/*max_attempts=*/1, [&] { return Attempt(); }), IsOk());
}

TEST_F(PeerCallsTest, SayWhyAPeerIsNotThereAfterOneWait) {
  const PeerCalls calls(channel_, {.connect_timeout = absl::Milliseconds(20)});

  EXPECT_THAT(calls.Run(/*max_attempts=*/8, [&] { return Attempt(); }),
              StatusIs(absl::StatusCode::kUnavailable,
                       AllOf(HasSubstr("peer: connection refused"),
                             HasSubstr("no connection within 20ms"))));
  EXPECT_EQ(attempts_, 1);
}

TEST_F(PeerCallsTest, TryAgainWhatAPeerThatIsThereRefusesForNow) {
  const PeerCalls calls(channel_, {.connect_timeout = absl::Seconds(30),
                                   .backoff = {.initial = {}, .longest = {}}});
  const auto server = Server::Start({.address = address_}, {&service_});
  ASSERT_THAT(server, IsOk());

  EXPECT_THAT(calls.Run(/*max_attempts=*/3,
                        [&] {
                          return ++attempts_ < 3
                                     ? absl::UnavailableError("busy")
                                     : absl::OkStatus();
                        }),
              IsOk());
}

TEST_F(PeerCallsTest, EndTheirWaitWhenStopped) {
  std::stop_source stop;
  const PeerCalls calls(channel_, {.connect_timeout = absl::InfiniteDuration(),
                                   .stop = stop.get_token()});
  const std::jthread stopper([&] { stop.request_stop(); });

  EXPECT_THAT(calls.Run(/*max_attempts=*/8, [&] { return Attempt(); }),
              StatusIs(absl::StatusCode::kCancelled));
}

}  // namespace
}  // namespace sinew::rpc
