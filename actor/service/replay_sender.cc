#include "actor/service/replay_sender.h"

#include <chrono>
#include <utility>

#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "common/logging.h"
#include "common/rpc/watchdog.h"
#include "replay/client/segment_stream.h"

namespace sinew::actor {

ReplaySender::ReplaySender(Options options, Outbox& outbox,
                           ActorMetrics& metrics, OnVerdict on_verdict)
    : options_(std::move(options)),
      outbox_(outbox),
      metrics_(metrics),
      on_verdict_(std::move(on_verdict)),
      backoff_(options_.backoff, rpc::FreshSeed()),
      thread_([this](const std::stop_token& stop) { Run(stop); }) {}

ReplaySender::~ReplaySender() = default;

void ReplaySender::SetPeer(std::shared_ptr<grpc::Channel> channel,
                           std::string peer) {
  std::stop_source replaced(std::nostopstate);
  {
    MutexLock lock(mu_);
    if (peer != peer_.name) {
      replaced = std::exchange(replace_, std::stop_source());
    }
    peer_ = {std::move(channel), std::move(peer), replace_.get_token()};
    changed_.NotifyAll();
  }
  // Not under the lock: this cancels a stream.
  replaced.request_stop();
}

ReplaySender::Peer ReplaySender::WaitForPeer(const std::stop_token& stop) {
  MutexLock lock(mu_);
  while (peer_.channel == nullptr && changed_.Wait(mu_, stop)) {
  }
  return peer_;
}

void ReplaySender::Run(const std::stop_token& stop) {
  while (outbox_.WaitForUnsent(stop)) {
    const Peer peer = WaitForPeer(stop);
    if (peer.channel == nullptr) return;
    const absl::Status status = Stream(peer, stop);
    outbox_.Rewind();
    if (stop.stop_requested()) return;
    if (peer.replaced.stop_requested()) {
      LogInfo("replay is elsewhere now",
              {{"before", peer.name}, {"unanswered_bytes", outbox_.bytes()}});
      backoff_.Reset();
      continue;
    }
    // Given up because nothing moved for long, since there was nothing.
    if (outbox_.bytes() == 0) continue;
    metrics_.reconnects.Increment();
    const absl::Duration wait = backoff_.Next();
    LogWarning("stream to replay broke",
               {{"reason", status.message()},
                {"retry_seconds", absl::ToDoubleSeconds(wait)}});
    // Another peer need not wait for this one's sake.
    std::stop_source over;
    const auto end = [&over] { over.request_stop(); };
    const std::stop_callback stopped(stop, end);
    const std::stop_callback replaced(peer.replaced, end);
    if (!rpc::WaitFor(wait, over.get_token()) && stop.stop_requested()) return;
  }
}

absl::Status ReplaySender::Stream(const Peer& peer,
                                  const std::stop_token& stop) {
  replay::SegmentStream stream(peer.channel, peer.name,
                               absl::InfiniteDuration());
  rpc::Watchdog watchdog(options_.stall_timeout,
                         [&stream] { stream.Cancel(); });
  std::stop_source broken;
  const auto end = [&] {
    broken.request_stop();
    stream.Cancel();
  };
  const std::stop_callback stopped(stop, end);
  const std::stop_callback replaced(peer.replaced, end);
  absl::Status status;
  std::jthread reader([&] {
    while (status.ok()) {
      const auto response = stream.Read();
      watchdog.Feed();
      if (!response.ok()) {
        status = response.status();
        break;
      }
      const OutgoingPtr segment = outbox_.Acknowledge(response->order_id());
      if (segment == nullptr) {
        status = absl::InternalError(
            absl::StrCat(peer.name, ": verdict for order ",
                         response->order_id(), ", which is not the next"));
        break;
      }
      backoff_.Reset();
      on_verdict_(*segment, *response);
    }
    broken.request_stop();
    stream.Cancel();
  });
  while (const OutgoingPtr segment = outbox_.NextUnsent(broken.get_token())) {
    const auto start = std::chrono::steady_clock::now();
    const bool sent =
        stream.Write(segment->run_id, segment->order_id, segment->bytes);
    metrics_.stage_seconds.Add(
        "send",
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start)
            .count());
    if (!sent) break;
    watchdog.Feed();
  }
  reader.join();
  return status;
}

}  // namespace sinew::actor
