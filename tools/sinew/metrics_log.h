#ifndef SINEW_TOOLS_SINEW_METRICS_LOG_H_
#define SINEW_TOOLS_SINEW_METRICS_LOG_H_

#include <cstdint>
#include <fstream>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "learner/trainer/trainer.h"

namespace sinew::tools {

// Seconds since the run began, over all its sessions.
struct RunSeconds {
  double wall = 0;
  double train = 0;  // without evaluation
};

// metrics.jsonl: one JSON object a line per iteration.
//
// Thread-safety: one caller. Blocking: on the disk; each row is flushed.
// Errors: those of the disk, naming the file.
class MetricsLog {
 public:
  // Opens or creates `path`; rows past `iteration` and an unfinished last line
  // are removed first (the run is resumed there).
  static absl::StatusOr<std::unique_ptr<MetricsLog>> Open(
      const std::string& path, int64_t iteration);

  absl::Status Write(const learner::IterationReport& report,
                     const RunSeconds& seconds);

 private:
  explicit MetricsLog(const std::string& path) : path_(path) {}

  const std::string path_;
  std::ofstream stream_;
};

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_SINEW_METRICS_LOG_H_
