#ifndef SINEW_COMMON_CPU_H_
#define SINEW_COMMON_CPU_H_

#include <string>

#include "absl/strings/string_view.h"

namespace sinew {

// What this process may use of the machine's processors. Pure after the first
// reading of /proc and /sys; thread-safe; blocks for microseconds.

// The thread budget: CPUs that the scheduler's affinity mask allows, cut to
// the quota of the control groups (version 1 or 2), rounded down; at least 1.
// Every role divides this number, nobody asks the machine for its cores.
int AvailableCpus();

// Feature class that floating-point results may depend on: the highest x86-64
// micro-architecture level of the psABI that processor and kernel support,
// "x86-64" or "x86-64-v2" to "x86-64-v4".
std::string CpuClass();

// Whether AVX-512 products of bfloat16 are there (bfloat16 training needs it).
bool HasBfloat16Products();

// Quota of the control group of this process in CPUs, or 0 if unlimited.
// `proc_self_cgroup` is the text of /proc/self/cgroup, `sys_fs_cgroup` the
// folder where the hierarchies are mounted. Unreadable limits count as none.
double CgroupCpuQuota(absl::string_view proc_self_cgroup,
                      const std::string& sys_fs_cgroup);

}  // namespace sinew

#endif  // SINEW_COMMON_CPU_H_
