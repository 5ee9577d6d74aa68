#ifndef SINEW_ACTOR_SERVICE_APPLIED_VERSIONS_H_
#define SINEW_ACTOR_SERVICE_APPLIED_VERSIONS_H_

#include <chrono>
#include <cstdint>
#include <deque>

#include "actor/service/actor_metrics.h"
#include "common/mutex.h"

namespace sinew::actor {

// How long a snapshot's version takes from being named in an order to being
// acted with. Thread-safe; never blocks; remembers the latest eight.
class AppliedVersions {
 public:
  using Time = std::chrono::steady_clock::time_point;

  explicit AppliedVersions(ActorMetrics& metrics) : metrics_(metrics) {}

  // An order named this version.
  void Hear(int64_t version, Time now) SINEW_EXCLUDES(mu_);

  // A rollout with it began; returns the seconds since Hear, for the first
  // rollout with it and all later ones.
  double Apply(int64_t version, Time now) SINEW_EXCLUDES(mu_);

 private:
  struct Entry {
    int64_t version = 0;
    Time heard;
    // Negative until applied.
    double seconds = -1;
  };

  Entry* Find(int64_t version) SINEW_REQUIRES(mu_);

  ActorMetrics& metrics_;
  Mutex mu_;
  // In order of hearing, which a learner that resumes makes fall.
  std::deque<Entry> entries_ SINEW_GUARDED_BY(mu_);
};

}  // namespace sinew::actor

#endif  // SINEW_ACTOR_SERVICE_APPLIED_VERSIONS_H_
