#ifndef SINEW_REPLAY_TABLE_H_
#define SINEW_REPLAY_TABLE_H_

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/container/flat_hash_set.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "absl/types/span.h"
#include "common/clock.h"
#include "common/mutex.h"
#include "proto/sinew/v1/replay.pb.h"
#include "proto/sinew/v1/state_limits.pb.h"
#include "replay/client/replay.h"
#include "replay/replay_metrics.h"
#include "replay/run_claim.h"
#include "replay/validate.h"

namespace sinew::replay {

// The expected segments of one run: bounded in bytes, first in, first out by
// iteration, keeps the first valid segment of each order.
//
//   Open:    order -> entry without segment          (at most limit per
//                                                     iteration, else refused)
//   Admit:   room for its bytes, or a refusal by key  (waits while full)
//   Put:     judged, then entry with segment
//   Collect: all entries of a list, once complete     (waits)
//   Remove:  entries are gone, ids remembered as taken
//
// Never stuck: a segment of iteration i is admitted only if the missing ones
// of all earlier iterations would still fit, and each iteration fits alone.
//
//   limit 100, iteration 1 misses 2 x 20, 50 used: 10 left for iteration 2
//
// Thread-safety: any thread. Ownership: owns its segments, shared with whoever
// collected them. Blocking: Admit and Collect as said, in steps of at most
// 100 ms between looks at `cancelled`. Errors: as Replay's (client/replay.h).
class Table {
 public:
  struct Options {
    // Bound of the serialised segments held or arriving, bytes, >= 1.
    int64_t limit_bytes = int64_t{256} << 20;
    // Tells how long ago a run was active (run_claim.h). Borrowed; null: the
    // machine's clocks.
    const Clock* clock = nullptr;
  };
  // Asked now and then by whoever waits; true: give up (CANCELLED).
  using Cancelled = std::function<bool()>;

  // Room in the table for one arriving segment; given back when destroyed.
  class Room;

  // Either room, or the verdict that refuses a segment by its key.
  struct Admission {
    std::optional<v1::PutSegmentResponse> refusal;
    std::unique_ptr<Room> room;
  };

  Table(const Options& options, ReplayMetrics& metrics);
  // Nobody is inside, no Room is left (CHECK).
  ~Table();
  Table(const Table&) = delete;
  Table& operator=(const Table&) = delete;

  absl::Status Open(const v1::OpenRequest& request) SINEW_EXCLUDES(mu_);

  // UNAVAILABLE: the table is closed; DEADLINE_EXCEEDED, CANCELLED.
  absl::StatusOr<Admission> Admit(const std::string& run_id, int64_t order_id,
                                  int64_t total_bytes, absl::Time deadline,
                                  const Cancelled& cancelled)
      SINEW_EXCLUDES(mu_);

  // Judges the bytes for which there is room, and keeps them if they are the
  // first valid ones. Computes outside the lock.
  v1::PutSegmentResponse Put(std::unique_ptr<Room> room,
                             absl::string_view bytes) SINEW_EXCLUDES(mu_);

  absl::StatusOr<std::vector<SegmentPtr>> Collect(
      const std::string& run_id, absl::Span<const int64_t> order_ids,
      absl::Time deadline, const Cancelled& cancelled) SINEW_EXCLUDES(mu_);

  void Remove(const std::string& run_id, absl::Span<const int64_t> order_ids)
      SINEW_EXCLUDES(mu_);

  v1::GetReplayStatusResponse Status() const SINEW_EXCLUDES(mu_);

  // Wakes everybody who waits; waiting is refused from now on.
  void Close() SINEW_EXCLUDES(mu_);

 private:
  struct Entry {
    std::shared_ptr<const Expectation> expectation;
    int64_t max_bytes = 0;
    // Null until accepted.
    SegmentPtr segment;
    int64_t bytes = 0;
  };

  // What the orders of a run share, as far as its learner has said it.
  struct Shared {
    std::shared_ptr<const v1::SegmentLayout> layout;
    std::shared_ptr<const v1::StateLimits> limits;
  };

  static absl::StatusOr<std::vector<Entry>> MakeEntries(
      const v1::OpenRequest& request, const Shared& shared);
  absl::Status CheckFits(const std::vector<Entry>& entries) const
      SINEW_REQUIRES(mu_);
  void Insert(Entry entry) SINEW_REQUIRES(mu_);
  // Fills an order's entry; its room becomes the entry's.
  void Keep(Room& room, SegmentPtr segment) SINEW_REQUIRES(mu_);
  void Reset() SINEW_REQUIRES(mu_);
  // The verdict that the key alone gives; nullopt: welcome.
  std::optional<v1::PutSegmentResponse> RefuseByKey(const std::string& run_id,
                                                    int64_t order_id,
                                                    int64_t total_bytes) const
      SINEW_REQUIRES(mu_);
  bool HasRoom(int64_t iteration, int64_t bytes) const SINEW_REQUIRES(mu_);
  // Waits one step; the status says why waiting is over.
  absl::Status WaitStep(absl::Time deadline, const Cancelled& cancelled)
      SINEW_REQUIRES(mu_);
  // The first of `order_ids` without segment; nullopt: all are there.
  absl::StatusOr<std::optional<int64_t>> FirstMissing(
      const std::string& run_id, absl::Span<const int64_t> order_ids) const
      SINEW_REQUIRES(mu_);
  void Count(const v1::PutSegmentResponse& response) SINEW_REQUIRES(mu_);
  void AddBytes(int64_t bytes) SINEW_REQUIRES(mu_);
  void GiveBack(const Room& room) SINEW_EXCLUDES(mu_);

  const Options options_;
  SystemClock system_clock_;
  ReplayMetrics& metrics_;
  mutable Mutex mu_;
  CondVar changed_;
  bool closed_ SINEW_GUARDED_BY(mu_) = false;
  RunClaim claim_ SINEW_GUARDED_BY(mu_);
  // Grows at every reset, so that what arrives late is told apart.
  int64_t generation_ SINEW_GUARDED_BY(mu_) = 0;
  Shared shared_ SINEW_GUARDED_BY(mu_);
  std::map<int64_t, Entry> entries_ SINEW_GUARDED_BY(mu_);
  // By iteration: largest possible bytes of entries without segment.
  std::map<int64_t, int64_t> missing_bytes_ SINEW_GUARDED_BY(mu_);
  // The latest ids that were taken, oldest first, and the same as a set.
  std::deque<int64_t> taken_order_ SINEW_GUARDED_BY(mu_);
  absl::flat_hash_set<int64_t> taken_ SINEW_GUARDED_BY(mu_);
  // Segments held plus room given out.
  int64_t bytes_ SINEW_GUARDED_BY(mu_) = 0;
  int64_t rooms_ SINEW_GUARDED_BY(mu_) = 0;
  int64_t accepted_ SINEW_GUARDED_BY(mu_) = 0;
  std::map<std::string, int64_t> refused_ SINEW_GUARDED_BY(mu_);
};

class Table::Room {
 public:
  ~Room() { table_.GiveBack(*this); }
  Room(const Room&) = delete;
  Room& operator=(const Room&) = delete;

 private:
  friend class Table;
  Room(Table& table, int64_t generation, int64_t bytes,
       std::shared_ptr<const Expectation> expectation)
      : table_(table),
        generation_(generation),
        bytes_(bytes),
        expectation_(std::move(expectation)) {}

  Table& table_;
  const int64_t generation_;
  int64_t bytes_;
  const std::shared_ptr<const Expectation> expectation_;
};

}  // namespace sinew::replay

#endif  // SINEW_REPLAY_TABLE_H_
