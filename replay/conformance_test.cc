// What every implementation of Replay must do: run on the table in process and
// on a client of the same table behind gRPC.
#include <cmath>
#include <cstdint>
#include <memory>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "common/metrics/registry.h"
#include "common/rpc/channel.h"
#include "common/rpc/server.h"
#include "common/rpc/testing/socket_folder.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "replay/client/replay.h"
#include "replay/client/replay_client.h"
#include "replay/local_replay.h"
#include "replay/replay_metrics.h"
#include "replay/service/replay_service.h"
#include "replay/table.h"
#include "replay/testing/segments.h"
#include "replay/validate.h"

namespace sinew::replay {
namespace {

using Response = v1::PutSegmentResponse;
using ::sinew::testing::EqualsProto;
using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AnyOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr absl::Duration kLong = absl::Minutes(1);

struct Backing {
  metrics::Registry registry{{.role = "replay", .build = ""}};
  ReplayMetrics metrics{registry};
  Table table{{.limit_bytes = 2 * MaxSegmentBytes(MakeExpectation(0))},
              metrics};
};

class InProcess {
 public:
  Replay& replay() { return replay_; }

 private:
  Backing backing_;
  LocalReplay replay_{backing_.table};
};

class OverGrpc {
 public:
  OverGrpc() {
    auto server =
        rpc::Server::Start({.address = folder_.Address("r")}, {&service_});
    EXPECT_THAT(server, IsOk());
    server_ = *std::move(server);
    replay_ = std::make_unique<ReplayClient>(
        *rpc::MakeChannel(server_->address(), {}),
        ReplayClient::Options{.peer = "replay"});
  }
  ~OverGrpc() { backing_.table.Close(); }

  Replay& replay() { return *replay_; }

 private:
  Backing backing_;
  rpc::SocketFolder folder_;
  ReplayService service_{backing_.table};
  std::unique_ptr<rpc::Server> server_;
  std::unique_ptr<Replay> replay_;
};

template <typename Implementation>
class ReplayConformance : public ::testing::Test {
 protected:
  Replay& replay() { return implementation_.replay(); }

  Response::Verdict Put(int64_t id, const std::string& bytes) {
    const auto response = replay().Put(kRun, id, bytes, kLong);
    EXPECT_THAT(response, IsOk());
    return response.ok() ? response->verdict() : Response::VERDICT_UNSPECIFIED;
  }

 private:
  Implementation implementation_;
};

using Implementations = ::testing::Types<InProcess, OverGrpc>;
TYPED_TEST_SUITE(ReplayConformance, Implementations);

TYPED_TEST(ReplayConformance, GivesBackTheSegmentsThatWereOpened) {
  ASSERT_THAT(this->replay().Open(MakeOpen({1, 2}, 0, true), {}), IsOk());
  EXPECT_EQ(this->Put(2, MakeSegmentBytes(2)), Response::VERDICT_ACCEPTED);
  EXPECT_EQ(this->Put(1, MakeSegmentBytes(1)), Response::VERDICT_ACCEPTED);

  const auto segments = this->replay().Take(kRun, {2, 1}, kLong, {});

  ASSERT_THAT(segments, IsOk());
  ASSERT_EQ(segments->size(), 2u);
  EXPECT_THAT(*(*segments)[0], EqualsProto(MakeSegment(1)));
  EXPECT_THAT(*(*segments)[1], EqualsProto(MakeSegment(2)));
}

TYPED_TEST(ReplayConformance, AnswersEachKindOfSegment) {
  ASSERT_THAT(this->replay().Open(MakeOpen({1}, 0, true), {}), IsOk());
  v1::Segment stale = MakeSegment(1);
  stale.set_snapshot_version(4);
  v1::Segment short_of_one = MakeSegment(1);
  short_of_one.mutable_columns()->RemoveLast();
  v1::Segment diverged = MakeSegment(1);
  diverged.mutable_end_states(0)->set_physics(0, std::nan(""));

  EXPECT_EQ(this->Put(9, MakeSegmentBytes(9)), Response::VERDICT_UNEXPECTED);
  EXPECT_EQ(this->Put(1, "junk"), Response::VERDICT_MALFORMED);
  EXPECT_EQ(this->Put(1, stale.SerializeAsString()), Response::VERDICT_STALE);
  EXPECT_EQ(this->Put(1, short_of_one.SerializeAsString()),
            Response::VERDICT_LAYOUT);
  EXPECT_EQ(this->Put(1, diverged.SerializeAsString()),
            Response::VERDICT_NON_FINITE);
  EXPECT_EQ(this->Put(1, MakeSegmentBytes(1)), Response::VERDICT_ACCEPTED);
  EXPECT_EQ(this->Put(1, MakeSegmentBytes(1)), Response::VERDICT_DUPLICATE);
}

TYPED_TEST(ReplayConformance, WaitsForTheLastSegment) {
  ASSERT_THAT(this->replay().Open(MakeOpen({1, 2}, 0, true), {}), IsOk());
  EXPECT_EQ(this->Put(1, MakeSegmentBytes(1)), Response::VERDICT_ACCEPTED);
  std::jthread writer([this] {
    EXPECT_EQ(this->Put(2, MakeSegmentBytes(2)), Response::VERDICT_ACCEPTED);
  });

  EXPECT_THAT(this->replay().Take(kRun, {1, 2}, kLong, {}), IsOk());
}

TYPED_TEST(ReplayConformance, TakesNothingWhenTimeIsUp) {
  ASSERT_THAT(this->replay().Open(MakeOpen({1, 2}, 0, true), {}), IsOk());
  EXPECT_EQ(this->Put(1, MakeSegmentBytes(1)), Response::VERDICT_ACCEPTED);

  EXPECT_THAT(this->replay().Take(kRun, {1, 2}, absl::Seconds(2), {}),
              StatusIs(absl::StatusCode::kDeadlineExceeded,
                       HasSubstr("segments of 2 orders; the first that is "
                                 "missing is 2")));
  EXPECT_THAT(this->replay().Take(kRun, {1}, kLong, {}), IsOk());
}

TYPED_TEST(ReplayConformance, StopsWaitingWhenAsked) {
  ASSERT_THAT(this->replay().Open(MakeOpen({1}, 0, true), {}), IsOk());
  std::stop_source stop;
  stop.request_stop();

  EXPECT_THAT(this->replay().Take(kRun, {1}, kLong, stop.get_token()),
              StatusIs(absl::StatusCode::kCancelled));
}

TYPED_TEST(ReplayConformance, AnswersOrIsCancelledWhenStopped) {
  std::stop_source stop;
  stop.request_stop();
  const auto at_once =
      AnyOf(absl::StatusCode::kOk, absl::StatusCode::kCancelled);

  EXPECT_THAT(
      this->replay().Open(MakeOpen({1}, 0, true), stop.get_token()).code(),
      at_once);
  EXPECT_THAT(this->replay().GetStatus(stop.get_token()).status().code(),
              at_once);
}

TYPED_TEST(ReplayConformance, SaysWhatIsWrongWithARequest) {
  ASSERT_THAT(this->replay().Open(MakeOpen({1}, 0, true), {}), IsOk());

  EXPECT_THAT(
      this->replay().Take(kRun, {5}, kLong, {}),
      StatusIs(absl::StatusCode::kNotFound, HasSubstr("order 5 is not open")));
  EXPECT_THAT(this->replay().Take(kRun, {1, 1}, kLong, {}),
              StatusIs(absl::StatusCode::kInvalidArgument));
  EXPECT_THAT(this->replay().Take("other", {1}, kLong, {}),
              StatusIs(absl::StatusCode::kFailedPrecondition));
  EXPECT_THAT(this->replay().Open(MakeOpen({1, 2, 3}), {}),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       HasSubstr("replay_bytes")));
  v1::OpenRequest wrong = MakeOpen({2});
  wrong.mutable_layout()->mutable_columns(0)->set_name("else");
  EXPECT_THAT(
      this->replay().Open(wrong, {}),
      StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("layout_sha256")));
}

TYPED_TEST(ReplayConformance, MakesAWriterWaitForRoom) {
  // Room for two segments: iteration 1 keeps it for its own.
  ASSERT_THAT(this->replay().Open(MakeOpen({1, 2}, 1, true), {}), IsOk());
  ASSERT_THAT(this->replay().Open(MakeOpen({3}, 2), {}), IsOk());

  EXPECT_THAT(this->replay().Put(kRun, 3, MakeSegmentBytes(3, 2),
                                 absl::Milliseconds(20)),
              StatusIs(absl::StatusCode::kDeadlineExceeded));

  EXPECT_EQ(this->Put(1, MakeSegmentBytes(1, 1)), Response::VERDICT_ACCEPTED);
  EXPECT_EQ(this->Put(2, MakeSegmentBytes(2, 1)), Response::VERDICT_ACCEPTED);
  // The first attempt may have gone through after its caller gave up.
  EXPECT_THAT(this->Put(3, MakeSegmentBytes(3, 2)),
              AnyOf(Response::VERDICT_ACCEPTED, Response::VERDICT_DUPLICATE));
}

TYPED_TEST(ReplayConformance, ReportsItsState) {
  ASSERT_THAT(this->replay().Open(MakeOpen({1, 3}, 0, true), {}), IsOk());
  const std::string bytes = MakeSegmentBytes(1);
  this->Put(1, bytes);
  this->Put(2, bytes);

  const auto status = this->replay().GetStatus({});

  ASSERT_THAT(status, IsOk());
  EXPECT_EQ(status->bytes(), static_cast<int64_t>(bytes.size()));
  EXPECT_EQ(status->accepted(), 1);
  EXPECT_EQ(status->refused().at("VERDICT_UNEXPECTED"), 1);
  EXPECT_THAT(status->missing_order_ids(), ElementsAre(3));
}

}  // namespace
}  // namespace sinew::replay
