#include "learner/dispatcher/session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "absl/status/status.h"

namespace sinew::learner {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// Nothing is started here, so nothing reacts.
class SilentOwner : public SessionOwner {
 public:
  void OnMessage(Session& /*session*/, bool /*ok*/) override {}
  void OnWritten(Session& /*session*/, bool /*ok*/) override {}
  void OnEnded(Session& /*session*/) override {}
};

class SessionTest : public ::testing::Test {
 protected:
  SessionActions Collect() {
    SessionActions actions;
    session_.Collect(actions);
    return actions;
  }

  static v1::DispatcherMessage OrderOf(int64_t id) {
    v1::DispatcherMessage message;
    message.mutable_order()->set_order_id(id);
    return message;
  }

  SilentOwner owner_;
  grpc::CallbackServerContext context_;
  Session session_{owner_, context_, /*id=*/1};
};

TEST_F(SessionTest, WritesOneMessageAfterTheOther) {
  session_.Push(OrderOf(1));
  session_.Push(OrderOf(2));

  EXPECT_THAT(Collect().write, ElementsAre(&session_));
  EXPECT_THAT(Collect().write, IsEmpty());
  session_.EndWrite();
  EXPECT_THAT(Collect().write, ElementsAre(&session_));
  session_.EndWrite();
  EXPECT_THAT(Collect().write, IsEmpty());
}

TEST_F(SessionTest, FinishesOnceAndAfterWhatIsQueued) {
  session_.Push(OrderOf(1));
  session_.Close(absl::OkStatus());
  session_.Push(OrderOf(2));  // too late

  EXPECT_THAT(Collect().write, ElementsAre(&session_));
  EXPECT_THAT(Collect().finish, IsEmpty());
  session_.EndWrite();
  const SessionActions last = Collect();
  EXPECT_THAT(last.write, IsEmpty());
  EXPECT_THAT(last.finish, ElementsAre(&session_));
  EXPECT_THAT(Collect().finish, IsEmpty());
}

// A second read may begin, on the reaction's thread, before the thread that
// began the first has said so.
TEST_F(SessionTest, DoesNotFinishWhileAnyReadIsBeingStarted) {
  session_.BeginStartRead();
  session_.BeginStartRead();
  session_.Close(absl::OkStatus());

  EXPECT_THAT(Collect().finish, IsEmpty());
  session_.EndStartRead();
  EXPECT_THAT(Collect().finish, IsEmpty());
  session_.EndStartRead();
  EXPECT_THAT(Collect().finish, ElementsAre(&session_));
}

TEST_F(SessionTest, TakesBackOrdersAndKeepsOtherMessages) {
  v1::DispatcherMessage drain;
  drain.mutable_drain()->set_reason("enough");
  session_.Push(OrderOf(1));
  EXPECT_THAT(Collect().write, ElementsAre(&session_));  // out of reach
  session_.Push(OrderOf(2));
  session_.Push(drain);
  session_.Push(OrderOf(3));

  EXPECT_THAT(session_.DropQueuedOrders(), ElementsAre(2, 3));
  session_.EndWrite();
  EXPECT_THAT(Collect().write, ElementsAre(&session_));  // the drain
  session_.EndWrite();
  EXPECT_THAT(Collect().write, IsEmpty());
}

}  // namespace
}  // namespace sinew::learner
