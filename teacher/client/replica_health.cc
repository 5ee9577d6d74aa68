#include "teacher/client/replica_health.h"

#include <algorithm>

#include "common/check.h"

namespace sinew::teacher {
namespace {

// Of the latest part in the usual time of one.
constexpr double kNewest = 0.2;
// Whatever happens wakes those that wait; a wait only has to end.
constexpr absl::Duration kLongestWait = absl::Hours(1);

bool IsAnswer(const absl::Status& status) {
  return absl::IsResourceExhausted(status) || absl::IsDataLoss(status);
}

}  // namespace

ReplicaHealth::ReplicaHealth(const Options& options, Clock& clock)
    : options_(options), clock_(clock) {
  SINEW_CHECK(options.replicas >= 1 && options.late_factor >= 1);
  for (int i = 0; i < options.replicas; ++i) {
    replicas_.push_back(
        {.backoff = rpc::Backoff(options_.backoff, rpc::FreshSeed()),
         .not_before = clock.SteadyNow()});
  }
}

std::optional<Clock::TimePoint> ReplicaHealth::ReadyFrom(int replica) const {
  MutexLock lock(mu_);
  const Replica& one = replicas_[replica];
  if (!one.present) return std::nullopt;
  return one.not_before;
}

bool ReplicaHealth::IsWell(int replica) const {
  MutexLock lock(mu_);
  const Replica& one = replicas_[replica];
  return one.present && !one.failed;
}

absl::Duration ReplicaHealth::LateAfter(int replica) const {
  MutexLock lock(mu_);
  return std::max(options_.late_floor,
                  options_.late_factor * replicas_[replica].usual);
}

absl::Status ReplicaHealth::LastError(int replica) const {
  MutexLock lock(mu_);
  return replicas_[replica].last_error;
}

void ReplicaHealth::Answered(int replica, absl::Duration took) {
  MutexLock lock(mu_);
  Replica& one = replicas_[replica];
  one.backoff.Reset();
  if (one.present) {
    one.failed = false;
    one.last_error = absl::OkStatus();
  }
  one.usual = one.usual == absl::ZeroDuration()
                  ? took
                  : one.usual + kNewest * (took - one.usual);
}

void ReplicaHealth::Failed(int replica, const absl::Status& status) {
  {
    MutexLock lock(mu_);
    Replica& one = replicas_[replica];
    if (!IsAnswer(status)) one.present = false;
    one.failed = true;
    one.last_error = status;
    one.not_before = clock_.After(one.backoff.Next());
  }
  changed_.NotifyAll();
}

void ReplicaHealth::Introduced(int replica) {
  MutexLock lock(mu_);
  Replica& one = replicas_[replica];
  one.present = true;
  one.failed = false;
  one.not_before = clock_.SteadyNow();
}

bool ReplicaHealth::AwaitTurn(int replica, const std::stop_token& stop) {
  MutexLock lock(mu_);
  const Replica& one = replicas_[replica];
  while (!stop.stop_requested()) {
    Clock::TimePoint wake = clock_.After(kLongestWait);
    if (!one.present) {
      if (clock_.SteadyNow() >= one.not_before) return true;
      wake = one.not_before;
    }
    clock_.WaitUntil(mu_, changed_, wake, stop);
  }
  return false;
}

}  // namespace sinew::teacher
