#ifndef SINEW_TOOLS_BENCH_TRANSPORT_FIGURES_H_
#define SINEW_TOOLS_BENCH_TRANSPORT_FIGURES_H_

#include <cstdint>

#include "absl/status/statusor.h"

namespace sinew::bench {

// Segments as track_clip's actors send them.
struct TransportOptions {
  int64_t observation_width = 224;
  int64_t action_width = 28;
  int environments = 8;  // per order
  int steps = 64;
  int orders = 16;  // per iteration
  int iterations = 10;
  // Control steps per second of training, for core_share.
  double samples_per_s = 10'000;
};

struct TransportFigures {
  int64_t bytes = 0;  // of all segments
  double bytes_per_sample = 0;
  double gb_per_s = 0;  // of the fastest iteration, 10^9 bytes
  // Processor seconds of sender, socket, replay and taking, per 10^9 bytes;
  // of the cheapest iteration.
  double core_s_per_gb = 0;
  // Share of one core that this costs at samples_per_s.
  double core_share = 0;
};

// Sends serialised segments through gRPC over a unix socket into a replay
// table, which judges them (parsed, every number looked at), and takes them out
// in process, as `sinew train` does: all in this process, so that its processor
// time is the cost of both sides.
//
// Blocking: about a second. Errors: those of replay; INTERNAL if a segment was
// not accepted.
absl::StatusOr<TransportFigures> MeasureTransport(
    const TransportOptions& options);

}  // namespace sinew::bench

#endif  // SINEW_TOOLS_BENCH_TRANSPORT_FIGURES_H_
