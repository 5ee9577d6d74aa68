#ifndef SINEW_TEACHER_CLIENT_TESTING_PART_QUEUE_RIG_H_
#define SINEW_TEACHER_CLIENT_TESTING_PART_QUEUE_RIG_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "common/testing/simulated_clock.h"
#include "teacher/client/part_queue.h"
#include "teacher/client/replica_health.h"

namespace sinew::teacher::testing {

// Of a batch for replicas "teacher a", "teacher b" ..., patience 60 s.
inline PartQueue::Options MakeOptions(int64_t parts, int replicas) {
  PartQueue::Options options;
  options.parts = parts;
  for (int i = 0; i < replicas; ++i) {
    options.peers.push_back(std::string("teacher ") +
                            static_cast<char>('a' + i));
  }
  options.patience = absl::Seconds(60);
  return options;
}

// A queue over replicas a, b ... that have been introduced.
struct PartQueueRig {
  PartQueueRig(int64_t parts, int replicas)
      : health({.replicas = replicas,
                .backoff = {.initial = absl::Seconds(1), .jitter = 0},
                .late_factor = 4,
                .late_floor = absl::Seconds(1)},
               clock),
        queue(MakeOptions(parts, replicas), health, clock) {
    for (int i = 0; i < replicas; ++i) health.Introduced(i);
  }

  // As an introduction does.
  void Come(int replica) {
    health.Introduced(replica);
    queue.Introduced(replica, absl::OkStatus());
  }

  sinew::testing::SimulatedClock clock;
  ReplicaHealth health;
  PartQueue queue;
};

}  // namespace sinew::teacher::testing

#endif  // SINEW_TEACHER_CLIENT_TESTING_PART_QUEUE_RIG_H_
