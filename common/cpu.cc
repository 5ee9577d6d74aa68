#include "common/cpu.h"

#include <sched.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_split.h"
#include "absl/strings/string_view.h"
#include "common/files.h"

namespace sinew {
namespace {

constexpr int64_t kMaxFileBytes = 1 << 20;
// Largest machine that is asked about, in CPUs.
constexpr int kMaxCpus = 1 << 14;

int CpusOfAffinityMask() {
  struct Free {
    void operator()(cpu_set_t* set) const { CPU_FREE(set); }
  };
  const std::unique_ptr<cpu_set_t, Free> set(CPU_ALLOC(kMaxCpus));
  const size_t size = CPU_ALLOC_SIZE(kMaxCpus);
  if (set != nullptr && sched_getaffinity(0, size, set.get()) == 0) {
    return CPU_COUNT_S(size, set.get());
  }
  return static_cast<int>(std::thread::hardware_concurrency());
}

// "QUOTA PERIOD" in microseconds as CPUs; 0 for "max", "-1" and nonsense.
double ParseQuota(absl::string_view text) {
  const std::vector<std::string> parts =
      absl::StrSplit(text, absl::ByAnyChar(" \n"), absl::SkipWhitespace());
  double quota = 0;
  double period = 0;
  if (parts.size() != 2 || !absl::SimpleAtod(parts[0], &quota) ||
      !absl::SimpleAtod(parts[1], &period) || quota <= 0 || period <= 0) {
    return 0;
  }
  return quota / period;
}

double QuotaOfFolder(const std::string& folder, bool version2) {
  if (version2) {
    const auto text = ReadFile(JoinPath(folder, "cpu.max"), kMaxFileBytes);
    return text.ok() ? ParseQuota(*text) : 0;
  }
  const auto quota =
      ReadFile(JoinPath(folder, "cpu.cfs_quota_us"), kMaxFileBytes);
  const auto period =
      ReadFile(JoinPath(folder, "cpu.cfs_period_us"), kMaxFileBytes);
  return quota.ok() && period.ok() ? ParseQuota(*quota + " " + *period) : 0;
}

// Smallest quota of a group and its ancestors; 0: none.
double LeastQuota(const std::string& root, std::string group, bool version2) {
  double least = 0;
  while (true) {
    const double quota = QuotaOfFolder(JoinPath(root, group), version2);
    if (quota > 0) least = least > 0 ? std::min(least, quota) : quota;
    if (group.empty()) return least;
    const size_t slash = group.rfind('/');
    group.resize(slash == std::string::npos ? 0 : slash);
  }
}

}  // namespace

double CgroupCpuQuota(absl::string_view proc_self_cgroup,
                      const std::string& sys_fs_cgroup) {
  double least = 0;
  const std::vector<std::string> lines = absl::StrSplit(proc_self_cgroup, '\n');
  for (const std::string& line : lines) {
    // "ID:CONTROLLERS:/PATH"; version 2 has id 0 and no controllers.
    const std::vector<std::string> parts =
        absl::StrSplit(line, absl::MaxSplits(':', 2));
    if (parts.size() != 3) continue;
    const std::vector<std::string> controllers = absl::StrSplit(parts[1], ',');
    const bool version2 = parts[1].empty();
    const bool version1 = std::find(controllers.begin(), controllers.end(),
                                    "cpu") != controllers.end();
    if (!version1 && !version2) continue;
    const std::string root =
        version2 ? sys_fs_cgroup : JoinPath(sys_fs_cgroup, "cpu");
    const double quota = LeastQuota(root, parts[2], version2);
    if (quota > 0) least = least > 0 ? std::min(least, quota) : quota;
  }
  return least;
}

int AvailableCpus() {
  static const int cpus = [] {
    int count = CpusOfAffinityMask();
    const auto groups = ReadFile("/proc/self/cgroup", kMaxFileBytes);
    const double quota =
        groups.ok() ? CgroupCpuQuota(*groups, "/sys/fs/cgroup") : 0;
    if (quota > 0 && quota < count) count = static_cast<int>(quota);
    return std::max(count, 1);
  }();
  return cpus;
}

std::string CpuClass() {
  __builtin_cpu_init();
  if (__builtin_cpu_supports("x86-64-v4")) return "x86-64-v4";
  if (__builtin_cpu_supports("x86-64-v3")) return "x86-64-v3";
  if (__builtin_cpu_supports("x86-64-v2")) return "x86-64-v2";
  return "x86-64";
}

bool HasBfloat16Products() {
  __builtin_cpu_init();
  return __builtin_cpu_supports("avx512bf16") != 0;
}

}  // namespace sinew
