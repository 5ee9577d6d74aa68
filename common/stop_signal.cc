#include "common/stop_signal.h"

#include <signal.h>
#include <unistd.h>

#include <atomic>

namespace sinew {
namespace {

constexpr int kQuitStatus = 130;  // shells' status after an interrupt

std::atomic<int> signals = 0;
static_assert(std::atomic<int>::is_always_lock_free);

void OnSignal(int) {
  if (signals.fetch_add(1) > 0) _exit(kQuitStatus);
}

}  // namespace

void CatchStopSignals() {
  struct sigaction action = {};
  action.sa_handler = OnSignal;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

bool StopRequested() { return signals.load() > 0; }

}  // namespace sinew
