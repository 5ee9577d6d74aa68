#ifndef SINEW_COMMON_METRICS_REGISTRY_H_
#define SINEW_COMMON_METRICS_REGISTRY_H_

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "prometheus/collectable.h"
#include "prometheus/counter.h"
#include "prometheus/gauge.h"
#include "prometheus/histogram.h"
#include "prometheus/registry.h"

namespace sinew::metrics {

using Counter = prometheus::Counter;
using Gauge = prometheus::Gauge;
using Histogram = prometheus::Histogram;
using Labels = std::map<std::string, std::string>;

// The series of one role. Series are declared where they move, each once, with
// help text; names by Prometheus' rules: sinew_<noun>_<unit>, base units,
// _total on counters only; labels from small fixed sets (stage, reason), never
// actors, environments or versions.
//
//   metrics::Counter& steps = registry.AddCounter(
//       "sinew_env_steps_total", "Control steps taken.");
//   steps.Increment(512);
//
// Thread-safety: any thread; the series too, lock-free. Ownership: owns the
// series, so it outlives whoever moves them. Blocking: never. Errors: a name
// that is not a metric name, or one name with two types, is our bug (CHECK).
class Registry {
 public:
  struct Info {
    // "actor", "replay", "learner", "teacher" or "checkpoint".
    std::string role;
    // Digest of the sources, as actors register it.
    std::string build;
  };

  // Declares sinew_build_info and the process_* series.
  explicit Registry(const Info& info);
  Registry(const Registry&) = delete;
  Registry& operator=(const Registry&) = delete;

  Counter& AddCounter(const std::string& name, const std::string& help,
                      const Labels& labels = {});
  Gauge& AddGauge(const std::string& name, const std::string& help,
                  const Labels& labels = {});
  // `upper_bounds` of the buckets, rising; +Inf is implied.
  Histogram& AddHistogram(const std::string& name, const std::string& help,
                          const std::vector<double>& upper_bounds,
                          const Labels& labels = {});

  // `update` moves series that say how things stand rather than what happened;
  // it is called at the beginning of each scrape, on the scrape's thread, one
  // scrape at a time, and must not block. What it uses outlives the endpoint.
  void BeforeScrape(std::function<void()> update);

  // Everything in Prometheus' text format, as a scrape sees it.
  std::string Text() const;

  // What an endpoint collects from (see MetricsServer), in this order.
  std::vector<std::shared_ptr<prometheus::Collectable>> collectables() const;

 private:
  class Updates;

  const std::shared_ptr<Updates> updates_;
  const std::shared_ptr<prometheus::Registry> registry_;
  const std::shared_ptr<prometheus::Collectable> process_;
};

// Buckets for waits and transfers: 1 ms to 60 s.
const std::vector<double>& SecondsBuckets();

}  // namespace sinew::metrics

#endif  // SINEW_COMMON_METRICS_REGISTRY_H_
