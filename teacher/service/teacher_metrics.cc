#include "teacher/service/teacher_metrics.h"

#include <string>
#include <utility>

namespace sinew::teacher {
namespace {

metrics::Counter& AddRequests(metrics::Registry& registry,
                              const std::string& result) {
  return registry.AddCounter("sinew_teacher_requests_total",
                             "Calls of Annotate by result.",
                             {{"result", result}});
}

}  // namespace

TeacherMetrics::TeacherMetrics(metrics::Registry& registry)
    : rows(registry.AddCounter("sinew_teacher_rows_total",
                               "Rows that were labelled.")),
      batch_rows(registry.AddHistogram("sinew_teacher_batch_rows",
                                       "Rows of a batch.",
                                       {1, 4, 16, 64, 256, 1024, 4096})),
      queue_rows(registry.AddGauge("sinew_teacher_queue_rows",
                                   "Rows that wait right now.")),
      queue_limit_rows(registry.AddGauge("sinew_teacher_queue_limit_rows",
                                         "Most rows that may wait.")),
      request_seconds(registry.AddHistogram("sinew_teacher_request_seconds",
                                            "From arrival to answer.",
                                            metrics::SecondsBuckets())),
      annotate_seconds(
          registry.AddCounter("sinew_stage_seconds_total",
                              "Seconds spent by stage, summed over threads.",
                              {{"stage", "annotate"}})),
      failed_(&AddRequests(registry, "failed")) {
  const std::pair<absl::StatusCode, const char*> results[] = {
      {absl::StatusCode::kOk, "ok"},
      {absl::StatusCode::kResourceExhausted, "full"},
      {absl::StatusCode::kDeadlineExceeded, "expired"},
      {absl::StatusCode::kCancelled, "cancelled"},
      {absl::StatusCode::kInvalidArgument, "invalid"},
      {absl::StatusCode::kFailedPrecondition, "other_bundle"},
      {absl::StatusCode::kUnavailable, "ending"}};
  for (const auto& [code, result] : results) {
    requests_[code] = &AddRequests(registry, result);
  }
}

void TeacherMetrics::Count(const absl::Status& status, double seconds) {
  const auto found = requests_.find(status.code());
  (found == requests_.end() ? failed_ : found->second)->Increment();
  request_seconds.Observe(seconds);
}

}  // namespace sinew::teacher
