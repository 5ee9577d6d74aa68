#include "common/build_info.h"

#include <unistd.h>

#include <array>
#include <string>

#include "common/digest.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew {
namespace {

using ::sinew::testing::IsOk;

TEST(BuildIdentity, IsTheDigestOfTheRunningProgram) {
  std::array<char, 4096> path = {};
  ASSERT_GT(readlink("/proc/self/exe", path.data(), path.size() - 1), 0);
  const auto program = ReadFile(path.data());
  ASSERT_THAT(program, IsOk());

  EXPECT_EQ(BuildIdentity(), Sha256Hex(*program));
  EXPECT_TRUE(IsSha256Hex(BuildIdentity()));
}

TEST(BuildIdentity, IsComputedOnce) {
  EXPECT_EQ(&BuildIdentity(), &BuildIdentity());
}

TEST(Version, HasThreeNumbers) {
  EXPECT_THAT(kVersion, ::testing::MatchesRegex("[0-9]+\\.[0-9]+\\.[0-9]+"));
}

}  // namespace
}  // namespace sinew
