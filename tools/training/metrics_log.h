#ifndef SINEW_TOOLS_TRAINING_METRICS_LOG_H_
#define SINEW_TOOLS_TRAINING_METRICS_LOG_H_

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

// What the trainer does not know of an iteration.
struct RunFigures {
  RunSeconds seconds;
  // Wall seconds since the row before: the iteration itself, and what came
  // between (saving, writing).
  double iteration_wall = 0;
  double save_seconds = 0;
  // Cores that the iteration could have used: actors and learner take turns
  // on them under lag 0.
  int cores = 1;
  int ranks = 1;  // threads that learned
  // Processor seconds used in iteration_wall by this process (learner and
  // replay) and by its actors; the latter -1 where they are elsewhere.
  double learner_cpu = 0;
  double actors_cpu = -1;
  int64_t actors = 0;
  int64_t orders_reissued = 0;  // in all
  int64_t save_failures = 0;    // by this process
};

// metrics.jsonl: one JSON object a line per iteration. Where core-seconds went:
// of cores * seconds.iteration, the actors' threads spent seconds.simulate,
// infer, observe, encode and evaluate, the learner ranks * seconds.learn and
// seconds.publish and save; the rest is waiting, sending and judging segments.
// While seconds.label pass nothing else is done: cores * seconds.label is what
// the teacher costs. `distillation` is there where the recipe has one.
// `eval` has `training` and `left_out` where clips are left out, and `drawn`
// where starts are drawn from some of those that are trained on; `plateau` is
// there where the recipe has one. An error of which no frame was measured is
// null.
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
                     const RunFigures& figures);

 private:
  explicit MetricsLog(const std::string& path) : path_(path) {}

  const std::string path_;
  std::ofstream stream_;
};

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_METRICS_LOG_H_
