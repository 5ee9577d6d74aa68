#include "replay/service/replay_server.h"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "common/metrics/registry.h"
#include "common/rpc/channel.h"
#include "common/rpc/server.h"
#include "common/rpc/status.h"
#include "common/rpc/testing/held_grpc.h"
#include "common/rpc/testing/socket_folder.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "grpcpp/client_context.h"
#include "gtest/gtest.h"
#include "proto/sinew/v1/replay.grpc.pb.h"
#include "replay/client/replay_client.h"
#include "replay/client/segment_stream.h"
#include "replay/testing/segments.h"

namespace sinew::replay {
namespace {

using Response = v1::PutSegmentResponse;
using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;

[[maybe_unused]] const auto* const held_grpc =
    ::testing::AddGlobalTestEnvironment(new rpc::HeldGrpc());

// Within a test's own limit, so that it says what it waited for.
constexpr absl::Duration kLong = absl::Seconds(30);

std::unique_ptr<ReplayClient> Connect(const std::string& address) {
  return std::make_unique<ReplayClient>(
      *rpc::MakeChannel(address, {}), ReplayClient::Options{.peer = "replay"});
}

TEST(ReplayServer, ServesATableOnThePortThatItFinds) {
  const auto server =
      ReplayServer::Create({.address = "127.0.0.1:0", .security = {}});
  ASSERT_THAT(server, IsOk());
  const auto client = Connect((*server)->address());

  ASSERT_THAT(client->Open(MakeOpen({1}, 0, true), {}), IsOk());
  ASSERT_THAT(client->Put(kRun, 1, MakeSegmentBytes(1), kLong), IsOk());
  EXPECT_THAT(client->Take(kRun, {1}, kLong, {}), IsOk());
  EXPECT_EQ(client->GetStatus({})->limit_bytes(), 256 << 20);
}

TEST(ReplayServer, NamesAnAddressThatIsInUse) {
  const auto first =
      ReplayServer::Create({.address = "127.0.0.1:0", .security = {}});
  ASSERT_THAT(first, IsOk());

  EXPECT_THAT(
      ReplayServer::Create({.address = (*first)->address(), .security = {}}),
      StatusIs(absl::StatusCode::kAlreadyExists,
               HasSubstr((*first)->address())));
}

TEST(ReplayServer, RefusesATableThatIsTooSmall) {
  EXPECT_THAT(
      ReplayServer::Create(
          {.address = "127.0.0.1:0", .security = {}, .limit_bytes = 1000}),
      StatusIs(absl::StatusCode::kInvalidArgument,
               AllOf(HasSubstr("bytes"), HasSubstr("found 1000"))));
}

TEST(ReplayServer, TellsWhoeverWaitsThatItGoesAway) {
  const auto server =
      ReplayServer::Create({.address = "127.0.0.1:0", .security = {}});
  ASSERT_THAT(server, IsOk());
  ASSERT_THAT(Connect((*server)->address())->Open(MakeOpen({1}, 0, true), {}),
              IsOk());
  const auto stub =
      v1::Replay::NewStub(*rpc::MakeChannel((*server)->address(), {}));
  grpc::ClientContext context;
  rpc::SetTimeout(context, kLong);
  v1::TakeRequest request;
  request.set_run_id(kRun);
  request.add_order_ids(1);
  const auto learner = stub->Take(&context, request);
  learner->WaitForInitialMetadata();  // it waits for the segment now

  const std::jthread end([&] { (*server)->Shutdown(kLong); });

  v1::TakeResponse chunk;
  EXPECT_FALSE(learner->Read(&chunk));
  EXPECT_THAT(rpc::FromGrpc(learner->Finish(), "replay"),
              StatusIs(absl::StatusCode::kUnavailable,
                       HasSubstr("replay is shutting down")));
}

// As gRPC answers for a server that began to shut down before the call came.
class CancellingService final : public v1::Replay::Service {
 public:
  grpc::Status Open(grpc::ServerContext*, const v1::OpenRequest*,
                    v1::OpenResponse*) override {
    return grpc::Status::CANCELLED;
  }
  grpc::Status Put(grpc::ServerContext*,
                   grpc::ServerReaderWriter<v1::PutSegmentResponse,
                                            v1::PutSegmentRequest>*) override {
    return grpc::Status::CANCELLED;
  }
  grpc::Status Take(grpc::ServerContext*, const v1::TakeRequest*,
                    grpc::ServerWriter<v1::TakeResponse>*) override {
    return grpc::Status::CANCELLED;
  }
};

TEST(ReplayClient, FindsThatAPeerIsAwayWhichCancelsItsCalls) {
  CancellingService service;
  const rpc::SocketFolder folder;
  const auto server =
      rpc::Server::Start({.address = folder.Address("r")}, {&service});
  ASSERT_THAT(server, IsOk());
  const auto client = Connect((*server)->address());
  const auto is_away = StatusIs(absl::StatusCode::kUnavailable,
                                HasSubstr("the peer ended the call"));

  EXPECT_THAT(client->Open(MakeOpen({1}, 0, true), {}), is_away);
  EXPECT_THAT(client->Put(kRun, 1, MakeSegmentBytes(1), kLong), is_away);
  EXPECT_THAT(client->Take(kRun, {1}, kLong, {}), is_away);
}

// Without the stop, each call waits for half a minute.
TEST(ReplayClient, DoesNotWaitForAPeerThatIsAwayOnceStopped) {
  const rpc::SocketFolder folder;
  const auto client = Connect(folder.Address("nobody"));
  StopSource stop;
  const std::jthread stopper([&] { stop.request_stop(); });

  EXPECT_THAT(client->Open(MakeOpen({1}, 0, true), stop.get_token()),
              StatusIs(absl::StatusCode::kCancelled));
  EXPECT_THAT(client->GetStatus(stop.get_token()),
              StatusIs(absl::StatusCode::kCancelled));
}

TEST(RunReplay, EndsWhenAskedTo) {
  const rpc::SocketFolder folder;
  StopSource stop;
  stop.request_stop();

  EXPECT_THAT(RunReplay({.address = folder.Address("r"),
                         .security = {},
                         .metrics_address = "127.0.0.1:0"},
                        stop.get_token()),
              IsOk());
}

// Evaluation segments: of any size up to their order's bound.
constexpr int kSegments = 48;
constexpr int kStarts = 300;  // 4 KiB each
constexpr int64_t kSegmentBytes = 1 << 20;

std::string MakeLargeSegmentBytes(int64_t order_id) {
  v1::Segment segment = MakeSegment(order_id);
  segment.set_iteration(order_id);
  segment.clear_columns();
  segment.clear_end_states();
  auto* numbers = segment.add_results()->mutable_sum_body_mm();
  numbers->Resize(kSegmentBytes / sizeof(double), 0.5);
  while (segment.results_size() < kStarts) segment.add_results();
  return segment.SerializeAsString();
}

v1::OpenRequest MakeLargeOpen() {
  v1::OpenRequest request;
  request.set_run_id(kRun);
  request.set_reset(true);
  for (int64_t id = 0; id < kSegments; ++id) {
    v1::OpenRequest::Expected& expected = *request.add_expected();
    expected = MakeExpected(id);
    expected.set_iteration(id);  // each iteration fits alone
    expected.set_steps(0);
    expected.set_environments(kStarts);
  }
  return request;
}

// An actor sends 48 MiB to a table of 4 MiB. It must not get far ahead of the
// learner, who takes one segment after the other, and nothing may be lost.
TEST(ReplayService, AFullTableStopsTheActorAndDropsNothing) {
  constexpr int64_t kLimit = 4 << 20;
  metrics::Registry registry({.role = "replay", .build = ""});
  ReplayMetrics metrics(registry);
  Table table({.limit_bytes = kLimit}, metrics);
  ReplayService service(table);
  const rpc::SocketFolder folder;
  const auto server =
      rpc::Server::Start({.address = folder.Address("r")}, {&service});
  ASSERT_THAT(server, IsOk());
  ASSERT_THAT(table.Open(MakeLargeOpen()), IsOk());
  SegmentStream stream(*rpc::MakeChannel((*server)->address(), {}), "replay",
                       kLong);
  std::atomic<int> written = 0;
  std::jthread actor([&] {
    for (int64_t id = 0; id < kSegments; ++id) {
      ASSERT_TRUE(stream.Write(kRun, id, MakeLargeSegmentBytes(id)));
      ++written;
    }
    stream.CloseWrites();
  });

  int ahead = 0;
  for (int64_t id = 0; id < kSegments; ++id) {
    const auto taken =
        table.Collect(kRun, {id}, absl::Now() + kLong, [] { return false; });
    ASSERT_THAT(taken, IsOk());
    EXPECT_LE(table.Status().bytes(), kLimit);
    // What the table, gRPC's windows and the socket hold: some MiB.
    ahead = std::max(ahead, written - static_cast<int>(id));
    table.Remove(kRun, {id});
    const auto verdict = stream.Read();
    ASSERT_THAT(verdict, IsOk());
    EXPECT_EQ(verdict->order_id(), id);
    EXPECT_EQ(verdict->verdict(), Response::VERDICT_ACCEPTED);
  }

  EXPECT_LT(ahead, kSegments / 2);
  EXPECT_THAT(stream.Read(), StatusIs(absl::StatusCode::kOutOfRange));
  EXPECT_EQ(table.Status().accepted(), kSegments);
  EXPECT_EQ(table.Status().bytes(), 0);
  table.Close();
}

}  // namespace
}  // namespace sinew::replay
