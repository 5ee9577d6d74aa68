#ifndef SINEW_LEARNER_EXPERIENCE_SERVICE_EXPERIENCE_H_
#define SINEW_LEARNER_EXPERIENCE_SERVICE_EXPERIENCE_H_

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "common/blobs/blob_ring.h"
#include "common/clock.h"
#include "common/rpc/retry.h"
#include "common/stop.h"
#include "learner/dispatcher/dispatcher.h"
#include "learner/trainer/experience.h"
#include "proto/sinew/v1/replay.pb.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "proto/sinew/v1/state_limits.pb.h"
#include "replay/client/replay.h"

namespace sinew::learner {

// Experience from actors, wherever they are:
//
//   Publish: snapshot -> ring, where actors fetch it
//   Begin:   1. replay expects the orders  2. the dispatcher hands them out
//   Take:    replay gives the segments up  -> the dispatcher forgets the orders
//
// A replay that is away for a while, or that has forgotten the run (it was
// started again), is no failure: all open orders are opened and handed out
// anew, and give the same bytes. So are orders that actors call done and that
// this replay misses all the same: another one has their segments. While Take
// waits, it says every `log_period` what is missing and how many actors there
// are; without any, where they should come to.
//
// Thread-safety: one caller. Ownership: borrows dispatcher, replay, ring and
// clock. Blocking: Begin for one call to replay, or until `stop`; Take until
// the segments are there, `stop` is requested (CANCELLED), `check` fails, or
// nothing has come in for `patience` although actors are there
// (DEADLINE_EXCEEDED), or replay keeps refusing an order's segment or actors
// keep sending it to another replay (FAILED_PRECONDITION). Errors: those, and
// what replay refuses for good (INVALID_ARGUMENT, FAILED_PRECONDITION,
// RESOURCE_EXHAUSTED naming run, order or iteration).
class ServiceExperience final : public Experience {
 public:
  struct Options {
    std::string run_id;
    // Columns of training segments, as orders' layout_sha256 names them.
    v1::SegmentLayout layout;
    // For replay to refuse what no rollout may go on from.
    v1::StateLimits limits;
    // Where actors find the dispatcher; for messages.
    std::string address;
    // Between two looks at `check`, where replay is there.
    absl::Duration step = absl::Seconds(1);
    absl::Duration log_period = absl::Seconds(10);
    absl::Duration patience = absl::Minutes(10);
    // Pauses between attempts while replay is away.
    rpc::BackoffOptions backoff = {.longest = absl::Seconds(5)};
    // Asked at each step; its failure ends Take. Unset: all is well.
    std::function<absl::Status()> check = {};
    StopToken stop = {};
  };

  ServiceExperience(Options options, Dispatcher& dispatcher,
                    replay::Replay& replay, BlobRing& snapshots, Clock& clock);

  absl::Status Publish(const PublishedSnapshot& snapshot) override;
  absl::Status Begin(const std::vector<v1::Order>& orders) override;
  absl::StatusOr<std::vector<v1::Segment>> Take(
      const std::vector<int64_t>& order_ids) override;

  // The run is over, or not to go on for now: another one may have replay at
  // once. Blocks for up to three calls to replay and the pauses between them;
  // does nothing where `stop` was requested, after which the same run is to go
  // on. A failure is logged: another run is refused for a minute then.
  void End();

 private:
  // What a Take that waits remembers.
  struct Wait {
    Clock::TimePoint next_log;
    Clock::TimePoint give_up;
    int64_t accepted = -1;
    int reopened = 0;
    int restored = 0;
  };

  absl::Status Open(const std::vector<v1::Order>& orders, bool reset);
  // Everything again, after replay was away.
  absl::Status Reopen();
  // One attempt of at most `step`; unset: not there yet.
  absl::StatusOr<std::optional<std::vector<replay::SegmentPtr>>> TryTake(
      const std::vector<int64_t>& order_ids, Wait& wait);
  absl::Status CheckProgress(const absl::Status& missing, Wait& wait);
  // Hands those of `finished` out again that replay misses.
  absl::Status Restore(const std::vector<int64_t>& finished,
                       const v1::GetReplayStatusResponse& replay, Wait& wait);

  const Options options_;
  Dispatcher& dispatcher_;
  replay::Replay& replay_;
  BlobRing& snapshots_;
  Clock& clock_;

  // Begun and not taken, by id.
  std::map<int64_t, v1::Order> open_orders_;
  rpc::Backoff backoff_;
  // Replay does not expect (all of) them: at the start, or after a failure.
  bool must_reopen_ = true;
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_EXPERIENCE_SERVICE_EXPERIENCE_H_
