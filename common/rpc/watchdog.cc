#include "common/rpc/watchdog.h"

#include <chrono>
#include <utility>

namespace sinew::rpc {
namespace {

CondVar::TimePoint After(absl::Duration timeout) {
  return std::chrono::steady_clock::now() + absl::ToChronoNanoseconds(timeout);
}

}  // namespace

Watchdog::Watchdog(absl::Duration timeout, std::function<void()> expired)
    : timeout_(timeout),
      expired_(std::move(expired)),
      deadline_(After(timeout)),
      thread_([this](const std::stop_token& stop) { Watch(stop); }) {}

Watchdog::~Watchdog() = default;

void Watchdog::Feed() {
  MutexLock lock(mu_);
  deadline_ = After(timeout_);
}

bool Watchdog::has_expired() const {
  MutexLock lock(mu_);
  return has_expired_;
}

void Watchdog::Watch(const std::stop_token& stop) {
  {
    MutexLock lock(mu_);
    while (std::chrono::steady_clock::now() < deadline_) {
      changed_.WaitUntil(mu_, deadline_, stop);
      if (stop.stop_requested()) return;
    }
    has_expired_ = true;
  }
  expired_();
}

}  // namespace sinew::rpc
