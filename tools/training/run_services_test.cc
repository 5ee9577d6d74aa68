#include "tools/training/run_services.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <memory>
#include <string>

#include "absl/time/time.h"
#include "common/build_info.h"
#include "common/cpu.h"
#include "common/metrics/testing/scrape.h"
#include "common/rpc/channel.h"
#include "common/rpc/testing/socket_folder.h"
#include "common/testing/matchers.h"
#include "grpcpp/client_context.h"
#include "proto/sinew/v1/dispatch.grpc.pb.h"

namespace sinew::tools {
namespace {

using ::sinew::metrics::testing::Scrape;
using ::sinew::testing::IsOk;
using ::testing::HasSubstr;
using ::testing::Not;

class RunServicesTest : public ::testing::Test {
 protected:
  std::unique_ptr<RunServices> Start(const std::string& replay_address = "") {
    auto services = RunServices::Start({.listen = sockets_.Address("learner"),
                                        .replay_address = replay_address,
                                        .metrics_address = "127.0.0.1:0",
                                        .run_id = "run",
                                        .assets_sha256 = "assets"});
    EXPECT_THAT(services, IsOk());
    return *std::move(services);
  }

  const rpc::SocketFolder sockets_;
};

// No iteration ends while all actors are lost: nothing else would say so.
TEST_F(RunServicesTest, ShowsActorsAsTheyAreNow) {
  const auto services = Start();
  EXPECT_THAT(Scrape(services->metrics_address()),
              HasSubstr("sinew_actors_connected 0\n"));
  const auto channel = rpc::MakeChannel(services->server().address(), {});
  ASSERT_THAT(channel, IsOk());
  const auto stub = v1::Dispatcher::NewStub(*channel);
  grpc::ClientContext context;
  rpc::SetTimeout(context, absl::Seconds(60));
  context.set_wait_for_ready(true);
  const auto stream = stub->Work(&context);
  v1::ActorMessage message;
  auto* actor = message.mutable_register_();
  actor->set_protocol_version(1);
  actor->set_build(BuildIdentity());
  actor->set_mujoco_version(mj_versionString());
  actor->set_cpu_class(CpuClass());
  actor->set_threads(1);
  actor->set_name("one");

  ASSERT_TRUE(stream->Write(message)) << stream->Finish().error_message();
  v1::DispatcherMessage welcome;
  ASSERT_TRUE(stream->Read(&welcome));

  EXPECT_THAT(Scrape(services->metrics_address()),
              HasSubstr("sinew_actors_connected 1\n"));
  stream->WritesDone();
  stream->Finish();
  EXPECT_THAT(Scrape(services->metrics_address()),
              HasSubstr("sinew_actors_connected 0\n"));
}

TEST_F(RunServicesTest, ShowsAReplayOnlyWhereItIs) {
  EXPECT_THAT(Scrape(Start()->metrics_address()),
              HasSubstr("sinew_segments_accepted_total"));
  EXPECT_THAT(Scrape(Start(sockets_.Address("replay"))->metrics_address()),
              Not(HasSubstr("sinew_segments_accepted_total")));
}

}  // namespace
}  // namespace sinew::tools
