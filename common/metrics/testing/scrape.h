#ifndef SINEW_COMMON_METRICS_TESTING_SCRAPE_H_
#define SINEW_COMMON_METRICS_TESTING_SCRAPE_H_

#include <string>

namespace sinew::metrics::testing {

// What a scraper of `address` (HOST:PORT of loopback) reads at /metrics: status
// line, headers and series. Blocks until the server closes the connection, a
// minute at most; test failures, and an empty or partial answer, where there is
// none.
std::string Scrape(const std::string& address);

}  // namespace sinew::metrics::testing

#endif  // SINEW_COMMON_METRICS_TESTING_SCRAPE_H_
