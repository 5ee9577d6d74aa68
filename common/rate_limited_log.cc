#include "common/rate_limited_log.h"

#include <cstdint>
#include <vector>

#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "common/clock.h"
#include "common/logging.h"
#include "common/mutex.h"

namespace sinew {

RateLimitedLog::RateLimitedLog(Logger& logger, LogLevel level,
                               absl::Duration period, const Clock& clock)
    : logger_(logger), level_(level), period_(period), clock_(clock) {}

void RateLimitedLog::Log(absl::string_view message, LogFields fields) {
  int64_t suppressed = 0;
  {
    MutexLock lock(mu_);
    if (clock_.SteadyNow() < next_) {
      ++suppressed_;
      return;
    }
    next_ = clock_.After(period_);
    suppressed = suppressed_;
    suppressed_ = 0;
  }
  std::vector<LogField> all(fields);
  if (suppressed > 0) all.push_back({"suppressed", suppressed});
  logger_.Write(level_, message, all);
}

}  // namespace sinew
