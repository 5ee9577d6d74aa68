#ifndef SINEW_LEARNER_TRAINER_EXPERIENCE_H_
#define SINEW_LEARNER_TRAINER_EXPERIENCE_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "proto/sinew/v1/snapshot.pb.h"

namespace sinew::learner {

// A snapshot with the bytes that its digest names.
struct PublishedSnapshot {
  v1::Snapshot snapshot;
  std::string bytes;   // deterministic serialisation
  std::string sha256;  // of bytes, hex
};

// Where the trainer's orders go and segments come from: actors behind a
// dispatcher and a replay table, or threads of this process.
//
//   Publish(snapshot 0) Begin(orders of iteration 0) Take(their ids)
//   Publish(snapshot 1) ...
//
// Segments are a pure function of orders, snapshots and assets: every
// implementation gives the same bytes (Segment.seconds apart).
//
// Thread-safety: one caller. Blocking: Take only, bounded by the
// implementation's deadline and stop token. Errors: Take gives
// DEADLINE_EXCEEDED or CANCELLED, or what a rollout failed with; nothing is
// taken then and Take may be called again.
class Experience {
 public:
  virtual ~Experience() = default;

  // Makes a snapshot available to orders that name it. The latest three are
  // kept.
  virtual absl::Status Publish(const PublishedSnapshot& snapshot) = 0;
  // Lets orders be run, in order of id.
  virtual absl::Status Begin(const std::vector<v1::Order>& orders) = 0;
  // The segments of orders that were begun, in the order of `order_ids`.
  virtual absl::StatusOr<std::vector<v1::Segment>> Take(
      const std::vector<int64_t>& order_ids) = 0;
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_TRAINER_EXPERIENCE_H_
