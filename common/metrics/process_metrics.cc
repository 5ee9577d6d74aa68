#include "common/metrics/process_metrics.h"

#include <sys/resource.h>
#include <unistd.h>

#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_split.h"
#include "absl/strings/string_view.h"
#include "common/files.h"

namespace sinew::metrics {
namespace {

using prometheus::MetricFamily;
using prometheus::MetricType;

constexpr int64_t kMaxProcBytes = 1 << 20;

MetricFamily Single(const std::string& name, const std::string& help,
                    MetricType type, double value) {
  MetricFamily family;
  family.name = name;
  family.help = help;
  family.type = type;
  prometheus::ClientMetric& metric = family.metric.emplace_back();
  metric.counter.value = value;
  metric.gauge.value = value;
  return family;
}

// Fields of /proc/self/stat from the third on (proc(5)), since the second may
// hold spaces.
std::optional<std::vector<double>> StatFields() {
  const absl::StatusOr<std::string> text =
      ReadFile("/proc/self/stat", kMaxProcBytes);
  if (!text.ok()) return std::nullopt;
  const size_t end_of_name = text->rfind(')');
  if (end_of_name == std::string::npos) return std::nullopt;
  std::vector<double> fields;
  for (absl::string_view field :
       absl::StrSplit(text->substr(end_of_name + 1), ' ', absl::SkipEmpty())) {
    double value = 0;
    if (!absl::SimpleAtod(field, &value)) value = 0;
    fields.push_back(value);
  }
  if (fields.size() < 22) return std::nullopt;
  return fields;
}

// Seconds since 1970 at which the machine started.
std::optional<double> BootTime() {
  const absl::StatusOr<std::string> text =
      ReadFile("/proc/stat", kMaxProcBytes);
  if (!text.ok()) return std::nullopt;
  for (absl::string_view line : absl::StrSplit(*text, '\n')) {
    const std::vector<absl::string_view> words = absl::StrSplit(line, ' ');
    double value = 0;
    if (words.size() == 2 && words[0] == "btime" &&
        absl::SimpleAtod(words[1], &value)) {
      return value;
    }
  }
  return std::nullopt;
}

void AddStat(std::vector<MetricFamily>& out) {
  const std::optional<std::vector<double>> stat = StatFields();
  if (!stat.has_value()) return;
  // Numbers of proc(5) minus 3: utime 14, stime 15, num_threads 20, starttime
  // 22, vsize 23, rss 24.
  const double ticks = static_cast<double>(sysconf(_SC_CLK_TCK));
  const double page = static_cast<double>(sysconf(_SC_PAGESIZE));
  out.push_back(Single(
      "process_cpu_seconds_total", "User and system CPU time spent, seconds.",
      MetricType::Counter, ((*stat)[11] + (*stat)[12]) / ticks));
  out.push_back(Single("process_threads", "Threads of the process.",
                       MetricType::Gauge, (*stat)[17]));
  out.push_back(Single("process_virtual_memory_bytes", "Virtual memory, bytes.",
                       MetricType::Gauge, (*stat)[20]));
  out.push_back(Single("process_resident_memory_bytes",
                       "Resident memory, bytes.", MetricType::Gauge,
                       (*stat)[21] * page));
  if (const std::optional<double> boot = BootTime()) {
    out.push_back(Single("process_start_time_seconds",
                         "Start of the process, seconds since 1970.",
                         MetricType::Gauge, *boot + (*stat)[19] / ticks));
  }
}

}  // namespace

std::vector<MetricFamily> ProcessMetrics::Collect() const {
  std::vector<MetricFamily> out;
  AddStat(out);
  const auto descriptors = ListDirectory("/proc/self/fd");
  if (descriptors.ok()) {
    out.push_back(Single("process_open_fds", "Open file descriptors.",
                         MetricType::Gauge,
                         static_cast<double>(descriptors->size())));
  }
  rlimit limit = {};
  if (getrlimit(RLIMIT_NOFILE, &limit) == 0) {
    out.push_back(Single("process_max_fds", "Limit of file descriptors.",
                         MetricType::Gauge,
                         static_cast<double>(limit.rlim_cur)));
  }
  return out;
}

}  // namespace sinew::metrics
