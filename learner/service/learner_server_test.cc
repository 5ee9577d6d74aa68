#include "learner/service/learner_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <thread>

#include "common/blobs/blob_client.h"
#include "common/blobs/blob_ring.h"
#include "common/rpc/channel.h"
#include "common/rpc/testing/socket_folder.h"
#include "common/testing/matchers.h"
#include "learner/client/dispatch_stream.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

constexpr absl::Duration kLong = absl::Seconds(60);

class LearnerServerTest : public ::testing::Test {
 protected:
  LearnerServer::Options Options() {
    LearnerServer::Options options;
    options.listen = folder_.Address("s");
    options.dispatcher.welcome.set_run_id("run");
    options.dispatcher.welcome.set_heartbeat_seconds(10);
    options.dispatcher.build = "build";
    options.assets = &assets_;
    return options;
  }

  std::shared_ptr<grpc::Channel> Channel() {
    auto channel = rpc::MakeChannel(folder_.Address("s"), {});
    EXPECT_THAT(channel, IsOk());
    return *channel;
  }

  rpc::SocketFolder folder_;
  BlobRing assets_{8};
};

TEST_F(LearnerServerTest, ServesSnapshotsAndAssetsByDigest) {
  const auto server = LearnerServer::Start(Options());
  ASSERT_THAT(server, IsOk());
  const std::string snapshot = (*server)->snapshots().Put("snapshot");
  const std::string asset = assets_.Put("asset");
  BlobClient client(Channel(), {.peer = "learner"});

  const auto first = client.GetBlob(snapshot);
  const auto second = client.GetBlob(asset);
  ASSERT_THAT(first, IsOk());
  ASSERT_THAT(second, IsOk());
  EXPECT_EQ(**first, "snapshot");
  EXPECT_EQ(**second, "asset");
}

v1::ActorMessage::Register MakeRegister() {
  v1::ActorMessage::Register request;
  request.set_protocol_version(1);
  request.set_build("build");
  request.set_threads(1);
  return request;
}

TEST_F(LearnerServerTest, TellsNobodyToGoWhereItEndsWithoutHavingDrained) {
  auto server = LearnerServer::Start(Options());
  ASSERT_THAT(server, IsOk());
  DispatchStream stream(Channel(), "learner");
  ASSERT_THAT(stream.Register(MakeRegister(), kLong), IsOk());

  const std::jthread end([&] { server->reset(); });

  EXPECT_THAT(stream.Read(), StatusIs(absl::StatusCode::kUnavailable,
                                      HasSubstr("going away")));
}

TEST_F(LearnerServerTest, EndsTheStreamsOfActorsWhenItDrains) {
  const auto server = LearnerServer::Start(Options());
  ASSERT_THAT(server, IsOk());
  DispatchStream stream(Channel(), "learner");
  ASSERT_THAT(stream.Register(MakeRegister(), kLong), IsOk());

  (*server)->Drain(kLong);

  const auto drain = stream.Read();
  ASSERT_THAT(drain, IsOk());
  EXPECT_TRUE(drain->has_drain());
  EXPECT_THAT(stream.Read(), StatusIs(absl::StatusCode::kOutOfRange));
}

TEST_F(LearnerServerTest, NamesAnAddressThatIsInUse) {
  const auto first = LearnerServer::Start(Options());
  ASSERT_THAT(first, IsOk());

  EXPECT_THAT(LearnerServer::Start(Options()),
              StatusIs(absl::StatusCode::kAlreadyExists,
                       HasSubstr(folder_.Address("s").substr(5))));
}

}  // namespace
}  // namespace sinew::learner
