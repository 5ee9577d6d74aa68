#include "replay/replay_metrics.h"

#include <string>

#include "absl/strings/ascii.h"
#include "absl/strings/strip.h"

namespace sinew::replay {

using Response = v1::PutSegmentResponse;

ReplayMetrics::ReplayMetrics(metrics::Registry& registry)
    : accepted(registry.AddCounter("sinew_segments_accepted_total",
                                   "Segments that replay accepted.")),
      taken(registry.AddCounter("sinew_segments_taken_total",
                                "Segments that the learner took out.")),
      bytes(registry.AddGauge("sinew_queue_bytes",
                              "Bytes of segments in the table, arriving ones "
                              "included.")),
      limit_bytes(registry.AddGauge("sinew_queue_limit_bytes",
                                    "Bound of the table in bytes.")),
      writers_waiting(registry.AddGauge(
          "sinew_writers_waiting", "Writers that wait for room right now.")),
      blocked_seconds(
          registry.AddCounter("sinew_stage_seconds_total",
                              "Seconds spent by stage, summed over threads.",
                              {{"stage", "blocked"}})) {
  for (int verdict = Response::VERDICT_DUPLICATE;
       verdict <= Response::Verdict_MAX; ++verdict) {
    const std::string name =
        Response::Verdict_Name(static_cast<Response::Verdict>(verdict));
    const std::string reason =
        absl::AsciiStrToLower(absl::StripPrefix(name, "VERDICT_"));
    refused[static_cast<Response::Verdict>(verdict)] = &registry.AddCounter(
        "sinew_segments_refused_total", "Segments refused, by reason.",
        {{"reason", reason}});
  }
}

}  // namespace sinew::replay
