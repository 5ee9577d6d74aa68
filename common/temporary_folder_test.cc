#include "common/temporary_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <memory>
#include <string>

#include "common/files.h"
#include "common/testing/matchers.h"

namespace sinew {
namespace {

using ::sinew::testing::IsOk;
using ::testing::SizeIs;

// Bytes that a unix socket's path may have.
constexpr size_t kSocketPath = 107;

TEST(TemporaryFolder, IsNewEachTimeAndOnlyForThisUser) {
  const auto one = TemporaryFolder::Create();
  const auto other = TemporaryFolder::Create();
  ASSERT_THAT(one, IsOk());
  ASSERT_THAT(other, IsOk());

  struct stat found = {};
  ASSERT_EQ(stat((*one)->path().c_str(), &found), 0);

  EXPECT_TRUE(S_ISDIR(found.st_mode));
  EXPECT_EQ(found.st_mode & 0777, 0700u);
  EXPECT_NE((*one)->path(), (*other)->path());
}

TEST(TemporaryFolder, LeavesRoomForTheNameOfASocket) {
  const auto folder = TemporaryFolder::Create();
  ASSERT_THAT(folder, IsOk());

  EXPECT_THAT(JoinPath((*folder)->path(), std::string(64, 'x')),
              SizeIs(::testing::Le(kSocketPath)));
}

TEST(TemporaryFolder, GoesWithAllThatItHolds) {
  auto folder = TemporaryFolder::Create();
  ASSERT_THAT(folder, IsOk());
  const std::string path = (*folder)->path();
  const std::string below = JoinPath(path, "a/b");
  ASSERT_THAT(MakeDirectories(below), IsOk());
  ASSERT_THAT(WriteFileAtomically(JoinPath(below, "file"), "text"), IsOk());

  folder->reset();

  struct stat found = {};
  EXPECT_NE(stat(path.c_str(), &found), 0);
}

}  // namespace
}  // namespace sinew
