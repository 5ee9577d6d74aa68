#include "common/rpc/peer_calls.h"

#include <algorithm>
#include <chrono>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "common/logging.h"
#include "common/rpc/status.h"

namespace sinew::rpc {
namespace {

using SteadyClock = std::chrono::steady_clock;

// How long a stop may go unnoticed: a wait on a channel cannot be ended.
constexpr absl::Duration kSlice = absl::Milliseconds(100);
// Whoever waits longer is told so.
constexpr absl::Duration kSilence = absl::Seconds(2);

}  // namespace

bool PeerCalls::AwaitConnection() const {
  const SteadyClock::time_point begin = SteadyClock::now();
  absl::Duration waited;
  bool told = false;
  while (!options_.stop.stop_requested()) {
    const absl::Duration slice =
        std::min(kSlice, options_.connect_timeout - waited);
    if (channel_->WaitForConnected(absl::ToChronoTime(absl::Now() + slice))) {
      return true;
    }
    waited = absl::FromChrono(SteadyClock::now() - begin);
    if (waited >= options_.connect_timeout) return false;
    if (waited >= kSilence && !told) {
      LogInfo("waiting for a connection", {{"peer", options_.peer}});
      told = true;
    }
  }
  return false;
}

absl::Status PeerCalls::Run(
    int max_attempts, const std::function<absl::Status()>& attempt) const {
  bool away = false;
  absl::Status last;
  const absl::Status status = Retry(
      Backoff(options_.backoff, FreshSeed()), max_attempts,
      [&](absl::Duration wait) {
        return !away && WaitFor(wait, options_.stop);
      },
      [&] {
        away = !AwaitConnection();
        last = attempt();
        return last;
      });
  // An answer is no absence, even where the peer came up in the last moment.
  if (!IsTransient(last) || !away || options_.stop.stop_requested()) {
    return status;
  }
  return absl::Status(
      last.code(),
      absl::StrCat(last.message(), " (no connection within ",
                   absl::FormatDuration(options_.connect_timeout), ")"));
}

}  // namespace sinew::rpc
