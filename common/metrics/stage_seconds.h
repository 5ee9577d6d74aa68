#ifndef SINEW_COMMON_METRICS_STAGE_SECONDS_H_
#define SINEW_COMMON_METRICS_STAGE_SECONDS_H_

#include <map>
#include <string>
#include <vector>

#include "common/metrics/registry.h"

namespace sinew::metrics {

// sinew_stage_seconds_total{stage}: where a role's core-seconds go. Thread-safe
// after construction. Errors: an undeclared stage is our bug (CHECK).
class StageSeconds {
 public:
  StageSeconds(Registry& registry, const std::vector<std::string>& stages);

  // `seconds` >= 0.
  void Add(const std::string& stage, double seconds);

 private:
  std::map<std::string, Counter*> counters_;
};

}  // namespace sinew::metrics

#endif  // SINEW_COMMON_METRICS_STAGE_SECONDS_H_
