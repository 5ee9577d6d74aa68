#ifndef SINEW_TOOLS_EVALUATION_REJECTED_CLIPS_H_
#define SINEW_TOOLS_EVALUATION_REJECTED_CLIPS_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace sinew::evaluation {

struct RejectedClip {
  std::string name;
  std::string reason;  // the gravest

  bool operator==(const RejectedClip&) const = default;
};

// The clips that the import of a library turned away after it had measured
// them, by report.json in its folder (sim/import/clip_report.h): success over
// everything imported counts them as failed. Files that are no motions are not
// among them. Unset where there is no report, or one of another library: as
// many clips as `clips` must have been kept.
//
// Thread-safety: any thread. Ownership: none. Blocking: on the disk. Errors:
// INVALID_ARGUMENT for a report that is none, with its path.
absl::StatusOr<std::optional<std::vector<RejectedClip>>> RejectedClips(
    const std::string& library, int clips);

}  // namespace sinew::evaluation

#endif  // SINEW_TOOLS_EVALUATION_REJECTED_CLIPS_H_
