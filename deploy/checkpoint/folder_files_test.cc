#include "deploy/checkpoint/folder_files.h"

#include <unistd.h>

#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::checkpoint {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::IsOkAndHolds;
using ::sinew::testing::StatusIs;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;
using ::testing::Pointee;

std::string NewFolder() {
  const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
  const std::string folder =
      JoinPath(::testing::TempDir(), absl::StrCat(info->name(), getpid()));
  EXPECT_THAT(RemoveRecursively(folder), IsOk());
  EXPECT_THAT(MakeDirectories(folder), IsOk());
  return folder;
}

Blob MakeBlob(const std::string& bytes) {
  return std::make_shared<const std::string>(bytes);
}

TEST(FolderFiles, ReturnWhatWasWritten) {
  const std::string folder = JoinPath(NewFolder(), "bundle");

  ASSERT_THAT(WriteFolder({{"a/b/c.stl", MakeBlob("c")}, {"d", MakeBlob("")}},
                          folder + "/"),
              IsOk());

  EXPECT_THAT(
      ReadFolder(folder),
      IsOkAndHolds(ElementsAre(Pair("a/b/c.stl", Pointee(std::string("c"))),
                               Pair("d", Pointee(std::string())))));
}

TEST(FolderFiles, LeaveWhatIsThereAlone) {
  const std::string parent = NewFolder();
  const std::string folder = JoinPath(parent, "bundle");
  ASSERT_THAT(WriteFolder({{"a", MakeBlob("old")}}, folder), IsOk());

  EXPECT_THAT(WriteFolder({{"a", MakeBlob("new")}}, folder),
              StatusIs(absl::StatusCode::kAlreadyExists, HasSubstr(folder)));

  EXPECT_THAT(ReadFile(JoinPath(folder, "a")), IsOkAndHolds("old"));
  EXPECT_THAT(ListDirectory(parent), IsOkAndHolds(ElementsAre("bundle")));
}

TEST(FolderFiles, LeaveNothingHalfWritten) {
  const std::string parent = NewFolder();

  // A file cannot be a folder, too.
  EXPECT_FALSE(WriteFolder({{"a", MakeBlob("x")}, {"a/b", MakeBlob("y")}},
                           JoinPath(parent, "bundle"))
                   .ok());

  EXPECT_THAT(ListDirectory(parent), IsOkAndHolds(ElementsAre()));
}

TEST(FolderFiles, RefuseLinksAndEmptyFolders) {
  const std::string folder = NewFolder();
  EXPECT_THAT(ReadFolder(folder), StatusIs(absl::StatusCode::kInvalidArgument,
                                           HasSubstr("expected files")));
  ASSERT_EQ(symlink("/etc/passwd", JoinPath(folder, "link").c_str()), 0);

  EXPECT_THAT(ReadFolder(folder), StatusIs(absl::StatusCode::kInvalidArgument,
                                           HasSubstr("link: expected a")));
  EXPECT_THAT(ReadFolder(JoinPath(folder, "absent")),
              StatusIs(absl::StatusCode::kNotFound));
}

}  // namespace
}  // namespace sinew::checkpoint
