#include "common/segment/row_episodes.h"

#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/segment/segment_layout.h"

namespace sinew {

absl::StatusOr<std::vector<int64_t>> EpisodesOfRows(
    const v1::Segment& segment) {
  const v1::Tensor& terminated = *FindColumn(segment, column::kTerminated);
  const std::string& failed = terminated.data();
  const std::string& cut = FindColumn(segment, column::kTruncated)->data();
  const int64_t environments = terminated.shape(1);
  if (segment.end_states_size() != environments) {
    return absl::InvalidArgumentError(absl::StrCat(
        "end_states: expected ", environments, ", one per environment, found ",
        segment.end_states_size()));
  }
  std::vector<int64_t> rows(failed.size());
  for (int64_t e = 0; e < environments; ++e) {
    int64_t episode = segment.end_states(static_cast<int>(e)).episode();
    for (int64_t row = static_cast<int64_t>(rows.size()) - environments + e;
         row >= 0; row -= environments) {
      if (failed[row] != 0 || cut[row] != 0) --episode;
      rows[row] = episode;
    }
    if (episode < 0) {
      return absl::InvalidArgumentError(absl::StrCat(
          "end_states[", e, "].episode: expected >= ",
          segment.end_states(static_cast<int>(e)).episode() - episode,
          ", the episodes that ended in these rows, found ",
          segment.end_states(static_cast<int>(e)).episode()));
    }
  }
  return rows;
}

}  // namespace sinew
