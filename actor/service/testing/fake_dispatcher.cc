#include "actor/service/testing/fake_dispatcher.h"

#include <algorithm>
#include <stop_token>
#include <thread>
#include <utility>

#include "common/rpc/status.h"

namespace sinew::actor {

using Stream =
    grpc::ServerReaderWriter<v1::DispatcherMessage, v1::ActorMessage>;

void FakeDispatcher::Add(const v1::Order& order) {
  MutexLock lock(mu_);
  orders_.push_back(order);
  changed_.NotifyAll();
}

void FakeDispatcher::Drain() {
  MutexLock lock(mu_);
  drain_ = true;
  changed_.NotifyAll();
}

void FakeDispatcher::Refuse(absl::Status status) {
  MutexLock lock(mu_);
  refusal_ = std::move(status);
}

void FakeDispatcher::WaitUntil(const std::function<bool()>& condition) {
  MutexLock lock(mu_);
  while (!condition()) changed_.Wait(mu_, std::stop_token());
}

void FakeDispatcher::WaitForRegistered(size_t count) {
  WaitUntil([&]() SINEW_NO_THREAD_SAFETY_ANALYSIS {
    return registered_.size() >= count;
  });
}

void FakeDispatcher::WaitForGiven(int count) {
  WaitUntil([&]() SINEW_NO_THREAD_SAFETY_ANALYSIS { return given_ >= count; });
}

void FakeDispatcher::WaitForDone(size_t count) {
  WaitUntil(
      [&]() SINEW_NO_THREAD_SAFETY_ANALYSIS { return done_.size() >= count; });
}

void FakeDispatcher::WaitForReturned(size_t count) {
  WaitUntil([&]() SINEW_NO_THREAD_SAFETY_ANALYSIS {
    return returned_.size() >= count;
  });
}

void FakeDispatcher::WaitForHeartbeats(int count) {
  WaitUntil(
      [&]() SINEW_NO_THREAD_SAFETY_ANALYSIS { return heartbeats_ >= count; });
}

void FakeDispatcher::WaitForWanted(int count) {
  WaitUntil([&]() SINEW_NO_THREAD_SAFETY_ANALYSIS { return wanted_ == count; });
}

std::set<int64_t> FakeDispatcher::done() const {
  MutexLock lock(mu_);
  std::set<int64_t> ids;
  for (const auto& done : done_) ids.insert(done.order_id());
  return ids;
}

std::vector<v1::ActorMessage::Done> FakeDispatcher::done_messages() const {
  MutexLock lock(mu_);
  return done_;
}

std::set<int64_t> FakeDispatcher::returned() const {
  MutexLock lock(mu_);
  return returned_;
}

std::vector<std::string> FakeDispatcher::reasons() const {
  MutexLock lock(mu_);
  return reasons_;
}

int FakeDispatcher::refused() const {
  MutexLock lock(mu_);
  return refused_;
}

std::vector<v1::ActorMessage::Register> FakeDispatcher::registered() const {
  MutexLock lock(mu_);
  return registered_;
}

void FakeDispatcher::TakeBack(Actor& actor, int64_t order_id) {
  const auto found = std::find_if(
      actor.held.begin(), actor.held.end(),
      [&](const v1::Order& order) { return order.order_id() == order_id; });
  if (found == actor.held.end()) return;
  orders_.push_back(std::move(*found));
  actor.held.erase(found);
}

void FakeDispatcher::Hear(Actor& actor, const v1::ActorMessage& message) {
  MutexLock lock(mu_);
  if (message.has_want()) {
    actor.wanted += message.want().count();
    wanted_ += message.want().count();
  } else if (message.has_heartbeat()) {
    ++heartbeats_;
  } else if (message.has_done()) {
    done_.push_back(message.done());
    std::erase_if(actor.held, [&](const v1::Order& order) {
      return order.order_id() == message.done().order_id();
    });
  } else if (message.has_return_()) {
    reasons_.push_back(message.return_().reason());
    for (int64_t id : message.return_().order_ids()) {
      returned_.insert(id);
      if (message.return_().refused()) {
        ++refused_;
        std::erase_if(actor.held, [id](const v1::Order& order) {
          return order.order_id() == id;
        });
      } else {
        TakeBack(actor, id);
      }
    }
  }
  changed_.NotifyAll();
}

void FakeDispatcher::Speak(Actor& actor, Stream& stream) {
  bool drain_sent = false;
  while (true) {
    v1::DispatcherMessage message;
    {
      MutexLock lock(mu_);
      while (!actor.gone && !(drain_ && !drain_sent) &&
             (drain_ || actor.wanted == 0 || orders_.empty())) {
        changed_.Wait(mu_, std::stop_token());
      }
      if (actor.gone) return;
      if (drain_) {
        message.mutable_drain()->set_reason("test");
        drain_sent = true;
      } else {
        *message.mutable_order() = orders_.front();
        actor.held.push_back(std::move(orders_.front()));
        orders_.pop_front();
        --actor.wanted;
        --wanted_;
        ++given_;
        changed_.NotifyAll();
      }
    }
    stream.Write(message);
  }
}

grpc::Status FakeDispatcher::Work(grpc::ServerContext* /*context*/,
                                  Stream* stream) {
  v1::ActorMessage message;
  if (!stream->Read(&message) || !message.has_register_()) {
    return grpc::Status(grpc::StatusCode::INVALID_ARGUMENT, "no registration");
  }
  Actor actor;
  {
    MutexLock lock(mu_);
    registered_.push_back(message.register_());
    changed_.NotifyAll();
    if (!refusal_.ok()) return rpc::ToGrpc(refusal_);
  }
  v1::DispatcherMessage welcome;
  *welcome.mutable_welcome() = welcome_;
  stream->Write(welcome);
  {
    std::jthread speaker([&] { Speak(actor, *stream); });
    while (stream->Read(&message)) Hear(actor, message);
    MutexLock lock(mu_);
    actor.gone = true;
    wanted_ -= actor.wanted;
    for (v1::Order& order : actor.held) orders_.push_front(std::move(order));
    changed_.NotifyAll();
  }
  return grpc::Status::OK;
}

}  // namespace sinew::actor
