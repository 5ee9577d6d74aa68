#ifndef SINEW_ACTOR_SERVICE_TESTING_FAKE_DISPATCHER_H_
#define SINEW_ACTOR_SERVICE_TESTING_FAKE_DISPATCHER_H_

#include <cstdint>
#include <deque>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "common/mutex.h"
#include "proto/sinew/v1/dispatch.grpc.pb.h"

namespace sinew::actor {

// A dispatcher without leases: gives each order once, to whoever wants one, and
// remembers what actors said. What an actor returns, or held when its stream
// broke, waits for the next one.
//
// Thread-safety: any thread. Waits last until what they wait for happens.
class FakeDispatcher final : public v1::Dispatcher::Service {
 public:
  explicit FakeDispatcher(v1::DispatcherMessage::Welcome welcome)
      : welcome_(std::move(welcome)) {}

  void Add(const v1::Order& order) SINEW_EXCLUDES(mu_);
  // Sends [drain] to every actor, now or when it comes.
  void Drain() SINEW_EXCLUDES(mu_);
  // Actors are refused from now on.
  void Refuse(absl::Status status) SINEW_EXCLUDES(mu_);

  // Until so many actors have registered, refused ones included.
  void WaitForRegistered(size_t count) SINEW_EXCLUDES(mu_);
  // Until so many orders have been given out, repeats included.
  void WaitForGiven(int count) SINEW_EXCLUDES(mu_);
  void WaitForDone(size_t count) SINEW_EXCLUDES(mu_);
  void WaitForReturned(size_t count) SINEW_EXCLUDES(mu_);
  void WaitForHeartbeats(int count) SINEW_EXCLUDES(mu_);
  // Until actors have asked for this many orders more than they got.
  void WaitForWanted(int count) SINEW_EXCLUDES(mu_);

  std::set<int64_t> done() const SINEW_EXCLUDES(mu_);
  std::vector<v1::ActorMessage::Done> done_messages() const SINEW_EXCLUDES(mu_);
  // An order that is given back goes to whoever wants one, perhaps to the same
  // actor, which gives it back again.
  std::set<int64_t> returned() const SINEW_EXCLUDES(mu_);
  std::vector<std::string> reasons() const SINEW_EXCLUDES(mu_);
  // Orders given back because replay refused them; they are not given again.
  int refused() const SINEW_EXCLUDES(mu_);
  std::vector<v1::ActorMessage::Register> registered() const
      SINEW_EXCLUDES(mu_);

  grpc::Status Work(
      grpc::ServerContext* context,
      grpc::ServerReaderWriter<v1::DispatcherMessage, v1::ActorMessage>* stream)
      override;

 private:
  struct Actor {
    int wanted = 0;
    bool gone = false;
    std::deque<v1::Order> held;
  };

  void WaitUntil(const std::function<bool()>& condition)
      SINEW_NO_THREAD_SAFETY_ANALYSIS;
  void Hear(Actor& actor, const v1::ActorMessage& message) SINEW_EXCLUDES(mu_);
  void TakeBack(Actor& actor, int64_t order_id) SINEW_REQUIRES(mu_);
  // The writer of one stream.
  void Speak(
      Actor& actor,
      grpc::ServerReaderWriter<v1::DispatcherMessage, v1::ActorMessage>& stream)
      SINEW_EXCLUDES(mu_);

  const v1::DispatcherMessage::Welcome welcome_;
  mutable Mutex mu_;
  CondVar changed_;
  std::deque<v1::Order> orders_ SINEW_GUARDED_BY(mu_);
  bool drain_ SINEW_GUARDED_BY(mu_) = false;
  absl::Status refusal_ SINEW_GUARDED_BY(mu_);
  int wanted_ SINEW_GUARDED_BY(mu_) = 0;
  int given_ SINEW_GUARDED_BY(mu_) = 0;
  int heartbeats_ SINEW_GUARDED_BY(mu_) = 0;
  std::vector<v1::ActorMessage::Done> done_ SINEW_GUARDED_BY(mu_);
  std::set<int64_t> returned_ SINEW_GUARDED_BY(mu_);
  std::vector<std::string> reasons_ SINEW_GUARDED_BY(mu_);
  int refused_ SINEW_GUARDED_BY(mu_) = 0;
  std::vector<v1::ActorMessage::Register> registered_ SINEW_GUARDED_BY(mu_);
};

}  // namespace sinew::actor

#endif  // SINEW_ACTOR_SERVICE_TESTING_FAKE_DISPATCHER_H_
