#ifndef SINEW_COMMON_METRICS_METRICS_SERVER_H_
#define SINEW_COMMON_METRICS_METRICS_SERVER_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "common/metrics/registry.h"

namespace prometheus {
class Exposer;
}  // namespace prometheus

namespace sinew::metrics {

// The endpoint http://HOST:PORT/metrics that Prometheus scrapes.
//
// Thread-safety: scrapes run on its own two threads. Ownership: owns threads
// and socket until destroyed; shares the registry's series, but the Registry
// must outlive it. Blocking: the destructor joins. Errors: Start.
class MetricsServer {
 public:
  // `address` is HOST:PORT; port 0 takes a free one. ALREADY_EXISTS: the port
  // is in use (named). INVALID_ARGUMENT: not such an address.
  static absl::StatusOr<std::unique_ptr<MetricsServer>> Start(
      const std::string& address, const Registry& registry);
  ~MetricsServer();

  // HOST:PORT with the port that was taken.
  const std::string& address() const { return address_; }

 private:
  MetricsServer(std::string address,
                std::unique_ptr<prometheus::Exposer> exposer);

  const std::string address_;
  const std::unique_ptr<prometheus::Exposer> exposer_;
};

}  // namespace sinew::metrics

#endif  // SINEW_COMMON_METRICS_METRICS_SERVER_H_
