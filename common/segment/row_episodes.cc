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
  // How many have ended before each row, then in all.
  std::vector<int64_t> rows(failed.size());
  std::vector<int64_t> ended(environments, 0);
  for (size_t row = 0; row < rows.size(); ++row) {
    int64_t& count = ended[row % environments];
    rows[row] = count;
    if (failed[row] != 0 || cut[row] != 0) ++count;
  }
  for (int64_t e = 0; e < environments; ++e) {
    const int64_t last = segment.end_states(static_cast<int>(e)).episode();
    if (last < ended[e]) {
      return absl::InvalidArgumentError(absl::StrCat(
          "end_states[", e, "].episode: expected >= ", ended[e],
          ", the episodes that ended in these rows, found ", last));
    }
    for (size_t row = e; row < rows.size(); row += environments) {
      rows[row] += last - ended[e];
    }
  }
  return rows;
}

}  // namespace sinew
