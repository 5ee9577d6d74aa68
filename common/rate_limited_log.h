#ifndef SINEW_COMMON_RATE_LIMITED_LOG_H_
#define SINEW_COMMON_RATE_LIMITED_LOG_H_

#include <cstdint>

#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "common/clock.h"
#include "common/logging.h"
#include "common/mutex.h"

namespace sinew {

// Passes at most one line per period on, however often it is called; the next
// line that passes says in `suppressed` how many did not.
//
// Thread-safety: yes. Ownership: borrows logger and clock. Blocking: as
// Logger. Errors: none.
class RateLimitedLog {
 public:
  RateLimitedLog(Logger& logger, LogLevel level, absl::Duration period,
                 const Clock& clock);

  void Log(absl::string_view message, LogFields fields = {})
      SINEW_EXCLUDES(mu_);

 private:
  Logger& logger_;
  const LogLevel level_;
  const absl::Duration period_;
  const Clock& clock_;

  Mutex mu_;
  Clock::TimePoint next_ SINEW_GUARDED_BY(mu_) = Clock::TimePoint::min();
  int64_t suppressed_ SINEW_GUARDED_BY(mu_) = 0;
};

}  // namespace sinew

#endif  // SINEW_COMMON_RATE_LIMITED_LOG_H_
