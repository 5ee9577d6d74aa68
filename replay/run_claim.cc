#include "replay/run_claim.h"

#include "absl/strings/str_cat.h"
#include "common/logging.h"

namespace sinew::replay {

absl::Status RunClaim::Begin(const std::string& run_id) {
  if (run_id != run_id_ && active_.has_value()) {
    const absl::Duration since =
        absl::FromChrono(clock_.SteadyNow() - *active_);
    if (since < kActive) {
      return absl::FailedPreconditionError(absl::StrCat(
          "run: replay serves \"", run_id_,
          "\", whose learner asked for segments ",
          absl::FormatDuration(absl::Trunc(since, absl::Seconds(1))),
          " ago, found \"", run_id,
          "\"; give it another replay, or, if that learner is gone, wait ",
          absl::FormatDuration(absl::Ceil(kActive - since, absl::Seconds(1))),
          " or restart replay"));
    }
  }
  if (run_id_.empty() || run_id == run_id_) {
    LogInfo("a learner starts its run at replay", {{"run", run_id}});
  } else {
    LogWarning("another run's learner takes replay over",
               {{"before", run_id_}, {"run", run_id}});
  }
  if (run_id != run_id_) active_.reset();
  run_id_ = run_id;
  return absl::OkStatus();
}

}  // namespace sinew::replay
