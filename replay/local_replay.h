#ifndef SINEW_REPLAY_LOCAL_REPLAY_H_
#define SINEW_REPLAY_LOCAL_REPLAY_H_

#include <cstdint>
#include <stop_token>
#include <string>
#include <vector>

#include "replay/client/replay.h"
#include "replay/table.h"

namespace sinew::replay {

// A table in this process behind the interface that others know: nothing is
// copied or serialised on the way out. Thread-safe; borrows the table; blocks
// and fails as the table does.
class LocalReplay : public Replay {
 public:
  explicit LocalReplay(Table& table) : table_(table) {}

  absl::Status Open(const v1::OpenRequest& request,
                    const std::stop_token& stop) override;
  absl::StatusOr<v1::PutSegmentResponse> Put(const std::string& run_id,
                                             int64_t order_id,
                                             absl::string_view bytes,
                                             absl::Duration timeout) override;
  absl::StatusOr<std::vector<SegmentPtr>> Take(
      const std::string& run_id, absl::Span<const int64_t> order_ids,
      absl::Duration timeout, const std::stop_token& stop) override;
  absl::StatusOr<v1::GetReplayStatusResponse> GetStatus(
      const std::stop_token& stop) override;

 private:
  Table& table_;
};

}  // namespace sinew::replay

#endif  // SINEW_REPLAY_LOCAL_REPLAY_H_
