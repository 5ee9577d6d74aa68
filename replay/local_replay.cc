#include "replay/local_replay.h"

#include <utility>

#include "absl/time/clock.h"
#include "common/status_macros.h"

namespace sinew::replay {

absl::Status LocalReplay::Open(const v1::OpenRequest& request,
                               const std::stop_token& /*stop*/) {
  return table_.Open(request);
}

absl::StatusOr<v1::PutSegmentResponse> LocalReplay::Put(
    const std::string& run_id, int64_t order_id, absl::string_view bytes,
    absl::Duration timeout) {
  SINEW_ASSIGN_OR_RETURN(
      Table::Admission admission,
      table_.Admit(run_id, order_id, static_cast<int64_t>(bytes.size()),
                   absl::Now() + timeout, [] { return false; }));
  if (admission.refusal.has_value()) return *std::move(admission.refusal);
  return table_.Put(std::move(admission.room), bytes);
}

absl::StatusOr<std::vector<SegmentPtr>> LocalReplay::Take(
    const std::string& run_id, absl::Span<const int64_t> order_ids,
    absl::Duration timeout, const std::stop_token& stop) {
  SINEW_ASSIGN_OR_RETURN(
      std::vector<SegmentPtr> segments,
      table_.Collect(run_id, order_ids, absl::Now() + timeout,
                     [&stop] { return stop.stop_requested(); }));
  table_.Remove(run_id, order_ids);
  return segments;
}

absl::StatusOr<v1::GetReplayStatusResponse> LocalReplay::GetStatus(
    const std::stop_token& /*stop*/) {
  return table_.Status();
}

}  // namespace sinew::replay
