#include "learner/dispatcher/testing/dispatcher_rig.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <utility>

#include "absl/time/time.h"
#include "common/rpc/channel.h"
#include "common/testing/matchers.h"
#include "gtest/gtest.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;

constexpr absl::Duration kHang = absl::Minutes(1);

}  // namespace

DispatcherRig::DispatcherRig(Clock& clock) {
  Dispatcher::Options options;
  options.welcome.set_run_id("run");
  options.welcome.set_heartbeat_seconds(10);
  options.build = "b1";
  options.mujoco_version = "4.0.0";
  options.cpu_class = "x86-64-v3";
  options.reissue_after = absl::Seconds(20);
  options.on_apply = [this](double seconds) {
    MutexLock lock(mu_);
    applied_.push_back(seconds);
    changed_.NotifyAll();
  };
  options.clock = &clock;
  dispatcher_ = Dispatcher::Create(options);
  auto server = rpc::Server::Start({.address = folder_.Address("d")},
                                   {dispatcher_->service()});
  EXPECT_THAT(server, IsOk());
  server_ = *std::move(server);
}

DispatcherRig::~DispatcherRig() {
  dispatcher_->Shutdown(absl::InfinitePast());
  server_->Shutdown(absl::Seconds(5));
}

void DispatcherRig::AwaitApplied(double seconds, int count) {
  const auto deadline =
      std::chrono::steady_clock::now() + absl::ToChronoSeconds(kHang);
  MutexLock lock(mu_);
  while (std::count(applied_.begin(), applied_.end(), seconds) < count) {
    if (!changed_.WaitUntil(mu_, deadline)) break;
  }
  EXPECT_EQ(std::count(applied_.begin(), applied_.end(), seconds), count);
}

v1::ActorMessage::Register MakeRegister(const std::string& name) {
  v1::ActorMessage::Register actor;
  actor.set_protocol_version(1);
  actor.set_build("b1");
  actor.set_mujoco_version("4.0.0");
  actor.set_cpu_class("x86-64-v3");
  actor.set_threads(2);
  actor.set_name(name);
  return actor;
}

std::vector<v1::Order> MakeOrders(std::initializer_list<int64_t> ids) {
  std::vector<v1::Order> orders;
  for (int64_t id : ids) orders.emplace_back().set_order_id(id);
  return orders;
}

TestActor::TestActor(DispatcherRig& rig, const std::string& name)
    : rig_(rig),
      name_(name),
      stream_(*rpc::MakeChannel(rig.address(), {}), "dispatcher"),
      watchdog_(kHang, [this] {
        ADD_FAILURE() << name_ << " hangs";
        stream_.Cancel();
      }) {}

absl::StatusOr<v1::DispatcherMessage::Welcome> TestActor::Register(
    const v1::ActorMessage::Register& request) {
  return stream_.Register(request, kHang);
}

void TestActor::Join() { EXPECT_THAT(Register(MakeRegister(name_)), IsOk()); }

void TestActor::Send(const v1::ActorMessage& message) { stream_.Send(message); }

void TestActor::Want(int count) {
  v1::ActorMessage message;
  message.mutable_want()->set_count(count);
  Send(message);
}

void TestActor::Done(int64_t order_id) {
  v1::Order order;
  order.set_order_id(order_id);
  order.set_issue(issues_[order_id]);
  Done(order);
}

void TestActor::Done(const v1::Order& order) {
  v1::ActorMessage message;
  message.mutable_done()->set_order_id(order.order_id());
  message.mutable_done()->set_issue(order.issue());
  message.mutable_done()->set_applied_version(version_);
  Send(message);
}

void TestActor::Return(std::vector<int64_t> order_ids) {
  v1::ActorMessage message;
  message.mutable_return_()->mutable_order_ids()->Add(order_ids.begin(),
                                                      order_ids.end());
  Send(message);
}

void TestActor::Refuse(int64_t order_id, const std::string& reason) {
  v1::ActorMessage message;
  message.mutable_return_()->add_order_ids(order_id);
  message.mutable_return_()->set_reason(reason);
  message.mutable_return_()->set_refused(true);
  Send(message);
}

void TestActor::Heartbeat() {
  v1::ActorMessage message;
  message.mutable_heartbeat();
  Send(message);
}

// A stream is handled in order: a message with an answer that can be waited
// for stands behind the others.
void TestActor::Sync() {
  static std::atomic<int> next = 1;
  const double mark = next++;
  v1::ActorMessage message;
  message.mutable_done()->set_order_id(-1);
  message.mutable_done()->set_applied_version(++version_);
  message.mutable_done()->set_apply_seconds(mark);
  Send(message);
  rig_.AwaitApplied(mark, 1);
}

std::optional<int64_t> TestActor::ReadOrder() {
  const auto message = stream_.Read();
  EXPECT_THAT(message, IsOk()) << name_;
  if (!message.ok() || !message->has_order()) return std::nullopt;
  issues_[message->order().order_id()] = message->order().issue();
  return message->order().order_id();
}

bool TestActor::ReadDrain() {
  const auto message = stream_.Read();
  EXPECT_THAT(message, IsOk()) << name_;
  return message.ok() && message->has_drain();
}

absl::Status TestActor::ReadEnd() {
  const auto message = stream_.Read();
  EXPECT_FALSE(message.ok()) << name_ << ": found a message";
  return message.status();
}

}  // namespace sinew::learner
