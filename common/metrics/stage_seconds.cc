#include "common/metrics/stage_seconds.h"

#include "common/check.h"

namespace sinew::metrics {

StageSeconds::StageSeconds(Registry& registry,
                           const std::vector<std::string>& stages) {
  for (const std::string& stage : stages) {
    counters_[stage] = &registry.AddCounter(
        "sinew_stage_seconds_total",
        "Seconds spent by stage, summed over threads.", {{"stage", stage}});
  }
}

void StageSeconds::Add(const std::string& stage, double seconds) {
  const auto found = counters_.find(stage);
  SINEW_CHECK(found != counters_.end()) << stage;
  found->second->Increment(seconds);
}

}  // namespace sinew::metrics
