#ifndef SINEW_COMMON_METRICS_TESTING_LINT_H_
#define SINEW_COMMON_METRICS_TESTING_LINT_H_

#include <string>

#include "absl/status/status.h"

namespace sinew::metrics {

// Runs `promtool check metrics` (Debian package prometheus) on a scrape.
// FAILED_PRECONDITION: its complaints, or that it is not installed.
absl::Status Lint(const std::string& text);

}  // namespace sinew::metrics

#endif  // SINEW_COMMON_METRICS_TESTING_LINT_H_
