#include "actor/service/replay_sender.h"

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "actor/service/actor_metrics.h"
#include "actor/service/outbox.h"
#include "common/metrics/registry.h"
#include "common/mutex.h"
#include "common/rpc/channel.h"
#include "common/rpc/server.h"
#include "common/rpc/testing/socket_folder.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "replay/testing/segments.h"
#include "replay/testing/test_replay.h"

namespace sinew::actor {
namespace {

using Response = v1::PutSegmentResponse;
using ::sinew::testing::IsOk;

// A replay on a socket of its own.
class Peer {
 public:
  Peer(const std::string& address, int64_t limit_bytes)
      : replay_(limit_bytes), address_(address) {
    EXPECT_THAT(replay_.Open(replay::MakeOpen({}, 0, /*reset=*/true)), IsOk());
    auto server =
        rpc::Server::Start({.address = address}, {&replay_.service()});
    EXPECT_THAT(server, IsOk());
    server_ = *std::move(server);
  }
  ~Peer() {
    replay_.Close();
    server_->Shutdown(absl::ZeroDuration());
  }

  void SetAsPeerOf(ReplaySender& sender) {
    auto channel = rpc::MakeChannel(address_, {});
    ASSERT_THAT(channel, IsOk());
    sender.SetPeer(*channel, address_);
  }
  replay::TestReplay& replay() { return replay_; }

 private:
  replay::TestReplay replay_;
  const std::string address_;
  std::unique_ptr<rpc::Server> server_;
};

class ReplaySenderTest : public ::testing::Test {
 protected:
  void Push(int64_t order_id) {
    auto segment = std::make_shared<OutgoingSegment>();
    segment->run_id = replay::kRun;
    segment->order_id = order_id;
    segment->bytes = replay::MakeSegmentBytes(order_id);
    ASSERT_TRUE(outbox_.Push(std::move(segment)));
  }

  Response::Verdict AwaitVerdict(int64_t order_id) {
    MutexLock lock(mu_);
    const auto deadline =
        std::chrono::steady_clock::now() + std::chrono::seconds(30);
    while (!verdicts_.contains(order_id)) {
      if (changed_.WaitUntil(mu_, deadline)) continue;
      ADD_FAILURE() << "order " << order_id << " has no verdict";
      return Response::VERDICT_UNSPECIFIED;
    }
    return verdicts_[order_id];
  }

  const rpc::SocketFolder folder_;
  // Room for one segment only in the first.
  Peer first_{folder_.Address("a"), replay::TestReplay::SegmentBytes()};
  Peer second_{folder_.Address("b"), int64_t{1} << 20};
  metrics::Registry registry_{{.role = "actor", .build = ""}};
  ActorMetrics metrics_{registry_};
  Outbox outbox_{int64_t{1} << 20};
  Mutex mu_;
  CondVar changed_;
  std::map<int64_t, Response::Verdict> verdicts_ SINEW_GUARDED_BY(mu_);
  ReplaySender sender_{
      {}, outbox_, metrics_, [this](const auto& segment, const auto& answer) {
        MutexLock lock(mu_);
        verdicts_[segment.order_id] = answer.verdict();
        changed_.NotifyAll();
      }};
};

TEST_F(ReplaySenderTest, LeavesALiveStreamOnceThereIsAnotherPeer) {
  ASSERT_THAT(first_.replay().Open(replay::MakeOpen({1})), IsOk());
  ASSERT_THAT(second_.replay().Open(replay::MakeOpen({2})), IsOk());
  first_.SetAsPeerOf(sender_);
  Push(1);
  ASSERT_EQ(AwaitVerdict(1), Response::VERDICT_ACCEPTED);

  second_.SetAsPeerOf(sender_);
  Push(2);

  // The first one would say VERDICT_UNEXPECTED.
  EXPECT_EQ(AwaitVerdict(2), Response::VERDICT_ACCEPTED);
  EXPECT_THAT(second_.replay().Take({2}), IsOk());
  EXPECT_EQ(metrics_.reconnects.Value(), 0);
}

TEST_F(ReplaySenderTest, SendsWhatHasNoAnswerToTheOtherPeer) {
  const auto full = first_.replay().OccupyRoom(9);
  ASSERT_THAT(first_.replay().Open(replay::MakeOpen({1}, 1'000'001)), IsOk());
  ASSERT_THAT(second_.replay().Open(replay::MakeOpen({1, 2})), IsOk());
  first_.SetAsPeerOf(sender_);
  Push(1);
  Push(2);

  second_.SetAsPeerOf(sender_);

  EXPECT_EQ(AwaitVerdict(1), Response::VERDICT_ACCEPTED);
  EXPECT_EQ(AwaitVerdict(2), Response::VERDICT_ACCEPTED);
  EXPECT_THAT(second_.replay().Take({1, 2}), IsOk());
}

TEST_F(ReplaySenderTest, StaysOnTheStreamToAPeerThatIsNamedAgain) {
  ASSERT_THAT(first_.replay().Open(replay::MakeOpen({1})), IsOk());
  first_.SetAsPeerOf(sender_);
  Push(1);
  ASSERT_EQ(AwaitVerdict(1), Response::VERDICT_ACCEPTED);
  ASSERT_THAT(first_.replay().Take({1}), IsOk());
  ASSERT_THAT(first_.replay().Open(replay::MakeOpen({2})), IsOk());

  first_.SetAsPeerOf(sender_);
  Push(2);

  EXPECT_EQ(AwaitVerdict(2), Response::VERDICT_ACCEPTED);
  EXPECT_EQ(metrics_.reconnects.Value(), 0);
}

}  // namespace
}  // namespace sinew::actor
