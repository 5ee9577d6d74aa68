#include "common/metrics/registry.h"

#include <iterator>
#include <utility>

#include "common/check.h"
#include "common/metrics/process_metrics.h"
#include "common/mutex.h"
#include "prometheus/check_names.h"
#include "prometheus/family.h"
#include "prometheus/text_serializer.h"

namespace sinew::metrics {

// Collects nothing: it comes first, and brings the others up to date.
class Registry::Updates : public prometheus::Collectable {
 public:
  void Add(std::function<void()> update) {
    MutexLock lock(mu_);
    updates_.push_back(std::move(update));
  }

  std::vector<prometheus::MetricFamily> Collect() const override {
    MutexLock lock(mu_);
    for (const auto& update : updates_) update();
    return {};
  }

 private:
  mutable Mutex mu_;
  std::vector<std::function<void()>> updates_ SINEW_GUARDED_BY(mu_);
};

Registry::Registry(const Info& info)
    : updates_(std::make_shared<Updates>()),
      registry_(std::make_shared<prometheus::Registry>()),
      process_(std::make_shared<ProcessMetrics>()) {
  AddGauge("sinew_build_info", "Always 1; the labels say what is running.",
           {{"role", info.role}, {"build", info.build}})
      .Set(1);
}

Counter& Registry::AddCounter(const std::string& name, const std::string& help,
                              const Labels& labels) {
  SINEW_CHECK(prometheus::CheckMetricName(name)) << name;
  return prometheus::BuildCounter()
      .Name(name)
      .Help(help)
      .Register(*registry_)
      .Add(labels);
}

Gauge& Registry::AddGauge(const std::string& name, const std::string& help,
                          const Labels& labels) {
  SINEW_CHECK(prometheus::CheckMetricName(name)) << name;
  return prometheus::BuildGauge()
      .Name(name)
      .Help(help)
      .Register(*registry_)
      .Add(labels);
}

Histogram& Registry::AddHistogram(const std::string& name,
                                  const std::string& help,
                                  const std::vector<double>& upper_bounds,
                                  const Labels& labels) {
  SINEW_CHECK(prometheus::CheckMetricName(name)) << name;
  return prometheus::BuildHistogram()
      .Name(name)
      .Help(help)
      .Register(*registry_)
      .Add(labels, upper_bounds);
}

void Registry::BeforeScrape(std::function<void()> update) {
  updates_->Add(std::move(update));
}

std::string Registry::Text() const {
  std::vector<prometheus::MetricFamily> families;
  for (const auto& collectable : collectables()) {
    std::vector<prometheus::MetricFamily> more = collectable->Collect();
    std::move(more.begin(), more.end(), std::back_inserter(families));
  }
  return prometheus::TextSerializer().Serialize(families);
}

std::vector<std::shared_ptr<prometheus::Collectable>> Registry::collectables()
    const {
  return {updates_, registry_, process_};
}

const std::vector<double>& SecondsBuckets() {
  static const auto& buckets = *new std::vector<double>{
      0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1, 3, 10, 30, 60};
  return buckets;
}

}  // namespace sinew::metrics
