#ifndef SINEW_REPLAY_CLIENT_REPLAY_H_
#define SINEW_REPLAY_CLIENT_REPLAY_H_

#include <cstdint>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "absl/types/span.h"
#include "proto/sinew/v1/replay.pb.h"
#include "proto/sinew/v1/rollout.pb.h"

namespace sinew::replay {

// A segment that replay has accepted: immutable, shared without copying.
using SegmentPtr = std::shared_ptr<const v1::Segment>;

// Replay as others see it: in this process (replay/local_replay.h) or behind
// gRPC (replay_client.h). One iteration of the learner:
//
//   Open(orders of iteration k)    what may come in
//   ... actors Put ...             first valid segment of each order stays
//   Take(those orders)             all of them out, in order of order_id
//
// A table serves one run at a time: Open with `reset` starts a run and drops
// what another one left. One whose Take calls came in the last 60 s is not
// dropped (FAILED_PRECONDITION, which names both), unless it said that it ends.
//
// Thread-safety: any thread. Ownership: results are shared. Blocking: each call
// at most its timeout, and of those with a `stop` none for longer than that is
// not requested (CANCELLED; a call that needs no waiting may be done all the
// same). Errors: name run and order, expected and found; from a peer also
// UNAVAILABLE and DEADLINE_EXCEEDED, which name it.
class Replay {
 public:
  virtual ~Replay() = default;

  // Says what is expected; may be repeated with equal content. An order that
  // was taken may be opened again. INVALID_ARGUMENT: a field out of range, or
  // a layout that is not the one of `layout_sha256`. FAILED_PRECONDITION: the
  // table holds another run; NOT_FOUND: none yet. RESOURCE_EXHAUSTED: one
  // iteration's segments may not fit into the table, which could wait for ever.
  virtual absl::Status Open(const v1::OpenRequest& request,
                            const std::stop_token& stop) = 0;

  // Puts one serialised segment and waits for the verdict: while the table has
  // no room, up to `timeout`. After DEADLINE_EXCEEDED a peer may have taken it
  // all the same; putting it again is harmless (VERDICT_DUPLICATE).
  virtual absl::StatusOr<v1::PutSegmentResponse> Put(
      const std::string& run_id, int64_t order_id, absl::string_view bytes,
      absl::Duration timeout) = 0;

  // Waits until the segments of all `order_ids` are there and takes them out,
  // in rising order of order_id. DEADLINE_EXCEEDED: some are missing (the
  // message says how many and names the first, unless the peer is away or
  // late); CANCELLED: `stop`; nothing is taken then. NOT_FOUND: an order, or
  // any run, is not open. If the connection broke just as the last bytes left
  // the peer, a second Take gives NOT_FOUND: open the orders again.
  virtual absl::StatusOr<std::vector<SegmentPtr>> Take(
      const std::string& run_id, absl::Span<const int64_t> order_ids,
      absl::Duration timeout, const std::stop_token& stop) = 0;

  // Bytes, limit and counters.
  virtual absl::StatusOr<v1::GetReplayStatusResponse> GetStatus(
      const std::stop_token& stop) = 0;
};

}  // namespace sinew::replay

#endif  // SINEW_REPLAY_CLIENT_REPLAY_H_
