#ifndef SINEW_ACTOR_SERVICE_REPLAY_SENDER_H_
#define SINEW_ACTOR_SERVICE_REPLAY_SENDER_H_

#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <thread>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "actor/service/actor_metrics.h"
#include "actor/service/outbox.h"
#include "common/mutex.h"
#include "common/rpc/retry.h"
#include "grpcpp/channel.h"
#include "proto/sinew/v1/replay.pb.h"

namespace sinew::actor {

// Sends an outbox's segments over one stream to replay, and again over another
// one, with back-off, when it breaks or stands still. What the learner's replay
// has not answered when the learner names another one goes there:
//
//   SetPeer(a)   segments 1 2 3 -> a, which answers 1
//   SetPeer(b)   the stream to a ends; 2 3 -> b
//
// Thread-safety: any thread. Ownership: borrows outbox and metrics; owns its
// threads, joined by the destructor, which cancels the stream. Blocking: the
// destructor, for milliseconds. Errors: logged and counted; sending goes on.
class ReplaySender {
 public:
  // Called with each verdict, in order, on a thread of the sender's.
  using OnVerdict = std::function<void(const OutgoingSegment&,
                                       const v1::PutSegmentResponse&)>;
  struct Options {
    rpc::BackoffOptions backoff;
    // A stream on which nothing moves for so long, with segments under way, is
    // given up.
    absl::Duration stall_timeout = absl::Minutes(5);
  };

  ReplaySender(Options options, Outbox& outbox, ActorMetrics& metrics,
               OnVerdict on_verdict);
  ~ReplaySender();

  // Where segments go from now on: a stream to a peer of another name ends, and
  // no segment that is pushed later gets there. With the same name, `channel`
  // serves from the next stream on. Nothing is sent before the first call.
  void SetPeer(std::shared_ptr<grpc::Channel> channel, std::string peer)
      SINEW_EXCLUDES(mu_);

 private:
  struct Peer {
    std::shared_ptr<grpc::Channel> channel;
    std::string name;
    // Requested once another peer takes its place.
    std::stop_token replaced;
  };

  void Run(const std::stop_token& stop);
  Peer WaitForPeer(const std::stop_token& stop) SINEW_EXCLUDES(mu_);
  // One stream; returns why it ended.
  absl::Status Stream(const Peer& peer, const std::stop_token& stop);

  const Options options_;
  Outbox& outbox_;
  ActorMetrics& metrics_;
  const OnVerdict on_verdict_;
  rpc::Backoff backoff_;
  Mutex mu_;
  CondVar changed_;
  Peer peer_ SINEW_GUARDED_BY(mu_);
  // What peer_.replaced hears of.
  std::stop_source replace_ SINEW_GUARDED_BY(mu_);
  // Last: the thread uses all of the above.
  std::jthread thread_;
};

}  // namespace sinew::actor

#endif  // SINEW_ACTOR_SERVICE_REPLAY_SENDER_H_
