#include "common/replace_directory.h"

#include <string>

#include "common/files.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::IsOkAndHolds;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// A fresh folder that holds the folder "new" with one file.
std::string MakeFolders() {
  const std::string folder =
      JoinPath(::testing::TempDir(),
               ::testing::UnitTest::GetInstance()->current_test_info()->name());
  EXPECT_THAT(RemoveRecursively(folder), IsOk());
  EXPECT_THAT(MakeDirectories(JoinPath(folder, "new")), IsOk());
  EXPECT_THAT(WriteFileAtomically(JoinPath(folder, "new/a"), "new"), IsOk());
  return folder;
}

TEST(ReplaceDirectory, MovesToAFreeName) {
  const std::string folder = MakeFolders();

  EXPECT_THAT(ReplaceDirectory(JoinPath(folder, "new"), JoinPath(folder, "to")),
              IsOk());

  EXPECT_THAT(ReadFile(JoinPath(folder, "to/a")), IsOkAndHolds("new"));
  EXPECT_THAT(ListDirectory(folder), IsOkAndHolds(ElementsAre("to")));
}

TEST(ReplaceDirectory, ReplacesAFolderWithAllThatItHeld) {
  const std::string folder = MakeFolders();
  ASSERT_THAT(MakeDirectories(JoinPath(folder, "to/deep")), IsOk());
  ASSERT_THAT(WriteFileAtomically(JoinPath(folder, "to/deep/b"), "old"),
              IsOk());

  EXPECT_THAT(ReplaceDirectory(JoinPath(folder, "new"), JoinPath(folder, "to")),
              IsOk());

  EXPECT_THAT(ListDirectory(JoinPath(folder, "to")),
              IsOkAndHolds(ElementsAre("a")));
  EXPECT_THAT(ListDirectory(folder), IsOkAndHolds(ElementsAre("to")));
}

TEST(ReplaceDirectory, KeepsTheOldOneIfThereIsNoNewOne) {
  const std::string folder = MakeFolders();

  EXPECT_THAT(
      ReplaceDirectory(JoinPath(folder, "none"), JoinPath(folder, "new")),
      StatusIs(absl::StatusCode::kNotFound,
               AllOf(HasSubstr("none"), HasSubstr("No such file"))));

  EXPECT_THAT(ReadFile(JoinPath(folder, "new/a")), IsOkAndHolds("new"));
}

}  // namespace
}  // namespace sinew
