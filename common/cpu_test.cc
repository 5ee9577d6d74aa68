#include "common/cpu.h"

#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew {
namespace {

using ::sinew::testing::IsOk;
using ::testing::AnyOf;
using ::testing::Contains;
using ::testing::Eq;

// A folder that looks like /sys/fs/cgroup, with the given files.
class FakeCgroups {
 public:
  FakeCgroups() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    root_ = JoinPath(::testing::TempDir(),
                     absl::StrCat("cgroup-", info->name(), "-", getpid()));
    EXPECT_THAT(RemoveRecursively(root_), IsOk());
  }

  FakeCgroups& With(const std::string& folder, const std::string& file,
                    const std::string& text) {
    EXPECT_THAT(MakeDirectories(JoinPath(root_, folder)), IsOk());
    EXPECT_THAT(
        WriteFileAtomically(JoinPath(JoinPath(root_, folder), file), text),
        IsOk());
    return *this;
  }

  const std::string& root() const { return root_; }

 private:
  std::string root_;
};

// Flags of the first processor as the kernel lists them.
std::vector<std::string> KernelFlags() {
  const auto text = ReadFile("/proc/cpuinfo");
  EXPECT_THAT(text, IsOk());
  const size_t flags = text->find("\nflags");
  const size_t colon = text->find(": ", flags) + 2;
  return absl::StrSplit(text->substr(colon, text->find('\n', colon) - colon),
                        ' ');
}

TEST(AvailableCpus, IsAtLeastOneAndAtMostTheAffinityMask) {
  cpu_set_t set;
  ASSERT_EQ(sched_getaffinity(0, sizeof(set), &set), 0);

  EXPECT_GE(AvailableCpus(), 1);
  EXPECT_LE(AvailableCpus(), CPU_COUNT(&set));
}

TEST(CgroupCpuQuota, ReadsVersion2) {
  FakeCgroups groups;
  groups.With("pod/box", "cpu.max", "150000 100000\n");

  EXPECT_EQ(CgroupCpuQuota("0::/pod/box\n", groups.root()), 1.5);
}

TEST(CgroupCpuQuota, TakesTheTightestOfAllAncestors) {
  FakeCgroups groups;
  groups.With("pod/box", "cpu.max", "max 100000\n")
      .With("pod", "cpu.max", "200000 100000\n")
      .With("", "cpu.max", "400000 100000\n");

  EXPECT_EQ(CgroupCpuQuota("0::/pod/box\n", groups.root()), 2);
}

TEST(CgroupCpuQuota, ReadsVersion1) {
  FakeCgroups groups;
  groups.With("cpu/box", "cpu.cfs_quota_us", "300000\n")
      .With("cpu/box", "cpu.cfs_period_us", "100000\n")
      .With("cpu", "cpu.cfs_quota_us", "-1\n")
      .With("cpu", "cpu.cfs_period_us", "100000\n");

  EXPECT_EQ(CgroupCpuQuota("5:memory:/box\n4:cpu,cpuacct:/box\n0::/x\n",
                           groups.root()),
            3);
}

TEST(CgroupCpuQuota, IsNoneWhereNothingCanBeRead) {
  FakeCgroups groups;
  groups.With("box", "cpu.max", "nonsense");

  EXPECT_EQ(CgroupCpuQuota("0::/box\n", groups.root()), 0);
  EXPECT_EQ(CgroupCpuQuota("0::/elsewhere\n", groups.root()), 0);
  EXPECT_EQ(CgroupCpuQuota("not a cgroup file", groups.root()), 0);
  EXPECT_EQ(CgroupCpuQuota("", groups.root()), 0);
}

TEST(CpuClass, AgreesWithTheKernelsFlags) {
  const std::vector<std::string> flags = KernelFlags();

  // The build's own level is v3, so nothing below can be met here.
  EXPECT_THAT(CpuClass(), AnyOf(Eq("x86-64-v3"), Eq("x86-64-v4")));
  if (CpuClass() == "x86-64-v4") {
    for (const char* flag : {"avx512f", "avx512bw", "avx512vl", "avx512dq"}) {
      EXPECT_THAT(flags, Contains(flag));
    }
  } else {
    EXPECT_THAT(flags, Contains("avx2"));
    EXPECT_THAT(flags, Contains("fma"));
  }
}

TEST(HasBfloat16Products, AgreesWithTheKernelsFlags) {
  const std::vector<std::string> flags = KernelFlags();

  EXPECT_EQ(HasBfloat16Products(), std::find(flags.begin(), flags.end(),
                                             "avx512_bf16") != flags.end());
}

}  // namespace
}  // namespace sinew
