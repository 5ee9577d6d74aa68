#ifndef SINEW_TOOLS_BENCH_TEACHER_FIGURES_H_
#define SINEW_TOOLS_BENCH_TEACHER_FIGURES_H_

#include <cstdint>

#include "absl/status/statusor.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew::bench {

struct TeacherOptions {
  int64_t observation_width = 224;
  int64_t action_width = 28;
  // Defaults filled.
  v1::Network network{};
  int64_t rows = 4096;  // of a batch
  int rounds = 9;
  int calls = 400;  // of one row, for the latency
};

struct TeacherFigures {
  // Rows per second through the service beside those of the bare executor;
  // median over rounds.
  double throughput_ratio = 0;
  double rows_per_s = 0;
  double executor_rows_per_s = 0;
  // A call of one row, ms: median and 99th percentile. The service's
  // batch_delay is in it.
  double latency_p50_ms = 0;
  double latency_p99_ms = 0;
};

// A teacher service on a unix socket with one thread, asked by a client of this
// process, and an executor on one thread that runs the same network over the
// same rows, in turns; wall time.
//
// Blocking: some seconds. Errors: those of service and client.
absl::StatusOr<TeacherFigures> MeasureTeacher(const TeacherOptions& options);

}  // namespace sinew::bench

#endif  // SINEW_TOOLS_BENCH_TEACHER_FIGURES_H_
