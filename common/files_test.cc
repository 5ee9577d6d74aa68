#include "common/files.h"

#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
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
using ::testing::IsEmpty;

// A folder of the running test's own, empty.
std::string MakeFolder() {
  const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
  const std::string folder = JoinPath(
      ::testing::TempDir(),
      absl::StrCat(info->test_suite_name(), "-", info->name(), "-", getpid()));
  EXPECT_THAT(RemoveRecursively(folder), IsOk());
  EXPECT_THAT(MakeDirectories(folder), IsOk());
  return folder;
}

// No file of this process may grow beyond `bytes` while it lives: the nearest
// to a full disk that needs no mount.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : handler_(signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit = {bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    signal(SIGXFSZ, handler_);
  }

 private:
  const sighandler_t handler_;
  rlimit before_;
};

TEST(ReadFile, ReturnsWhatWasWritten) {
  const std::string path = JoinPath(MakeFolder(), "f");
  const std::string content("line\n\0\xff", 7);

  ASSERT_THAT(WriteFileAtomically(path, content), IsOk());

  EXPECT_THAT(ReadFile(path), IsOkAndHolds(content));
}

TEST(ReadFile, NamesThePathThatIsMissing) {
  const std::string path = JoinPath(MakeFolder(), "nowhere");

  EXPECT_THAT(ReadFile(path),
              StatusIs(absl::StatusCode::kNotFound,
                       "cannot read " + path + ": No such file or directory"));
}

TEST(ReadFile, RefusesAFolder) {
  EXPECT_THAT(ReadFile(MakeFolder()),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("Is a directory")));
}

TEST(ReadFile, RefusesAPipeThatNobodyWritesTo) {
  const std::string path = JoinPath(MakeFolder(), "pipe");
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);

  EXPECT_THAT(ReadFile(path),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       "cannot read " + path + ": not a regular file"));
}

TEST(ReadFile, RefusesMoreThanTheBound) {
  const std::string path = JoinPath(MakeFolder(), "f");
  ASSERT_THAT(WriteFileAtomically(path, "12345"), IsOk());

  EXPECT_THAT(ReadFile(path, 5), IsOkAndHolds("12345"));
  EXPECT_THAT(ReadFile(path, 4),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "cannot read " + path + ": larger than 4 bytes"));
}

TEST(ReadFile, ReadsFilesThatDoNotKnowTheirSize) {
  EXPECT_THAT(ReadFile("/proc/self/stat"),
              IsOkAndHolds(HasSubstr(absl::StrCat(getpid()))));
  EXPECT_THAT(ReadFile("/proc/self/stat", 3),
              StatusIs(absl::StatusCode::kResourceExhausted));
}

TEST(WriteFileAtomically, ReplacesAndLeavesNothingElse) {
  const std::string folder = MakeFolder();
  const std::string path = JoinPath(folder, "f");

  ASSERT_THAT(WriteFileAtomically(path, "old and long"), IsOk());
  ASSERT_THAT(WriteFileAtomically(path, "new"), IsOk());

  EXPECT_THAT(ReadFile(path), IsOkAndHolds("new"));
  EXPECT_THAT(ListDirectory(folder), IsOkAndHolds(ElementsAre("f")));
}

TEST(WriteFileAtomically, KeepsTheOldContentWhenTheDiskIsFull) {
  const std::string folder = MakeFolder();
  const std::string path = JoinPath(folder, "f");
  ASSERT_THAT(WriteFileAtomically(path, "old"), IsOk());

  absl::Status status;
  {
    const FileSizeLimit limit(1000);
    status = WriteFileAtomically(path, std::string(5000, 'x'));
  }

  EXPECT_THAT(status, StatusIs(absl::StatusCode::kResourceExhausted,
                               AllOf(HasSubstr("cannot write " + path),
                                     HasSubstr("File too large"))));
  EXPECT_THAT(ReadFile(path), IsOkAndHolds("old"));
  EXPECT_THAT(ListDirectory(folder), IsOkAndHolds(ElementsAre("f")));
}

TEST(WriteFileAtomically, NeedsTheFolder) {
  EXPECT_THAT(
      WriteFileAtomically(JoinPath(MakeFolder(), "no/f"), "x"),
      StatusIs(absl::StatusCode::kNotFound, HasSubstr("cannot create")));
}

TEST(CheckFolderOf, SaysWhereAFileCouldNotBeWritten) {
  const std::string folder = MakeFolder();
  ASSERT_THAT(WriteFileAtomically(JoinPath(folder, "f"), "x"), IsOk());

  EXPECT_THAT(CheckFolderOf("here"), IsOk());
  EXPECT_THAT(CheckFolderOf(JoinPath(folder, "new")), IsOk());
  EXPECT_THAT(
      CheckFolderOf(JoinPath(folder, "no/new")),
      StatusIs(absl::StatusCode::kNotFound, HasSubstr(JoinPath(folder, "no"))));
  EXPECT_THAT(CheckFolderOf(JoinPath(folder, "f/new")),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("expected " + JoinPath(folder, "f"))));
}

TEST(WriteFileAtomically, LeavesOneWholeContentWhenManyWriteAtOnce) {
  const std::string folder = MakeFolder();
  const std::string path = JoinPath(folder, "f");
  std::vector<std::thread> threads;

  for (char c : {'a', 'b', 'c'}) {
    threads.emplace_back([&path, c] {
      EXPECT_THAT(WriteFileAtomically(path, std::string(100000, c)), IsOk());
    });
  }
  for (std::thread& thread : threads) thread.join();

  const absl::StatusOr<std::string> content = ReadFile(path);
  ASSERT_THAT(content, IsOk());
  EXPECT_EQ(*content, std::string(100000, (*content)[0]));
  EXPECT_THAT(ListDirectory(folder), IsOkAndHolds(ElementsAre("f")));
}

TEST(IsTemporaryName, KnowsOnlyTemporaryFiles) {
  EXPECT_TRUE(IsTemporaryName("state.sinew-tmp-12-0"));
  EXPECT_FALSE(IsTemporaryName("state.tmp"));
}

TEST(AppendToFile, CreatesThenAppends) {
  const std::string path = JoinPath(MakeFolder(), "f");

  ASSERT_THAT(AppendToFile(path, "a\n"), IsOk());
  ASSERT_THAT(AppendToFile(path, "b\n"), IsOk());

  EXPECT_THAT(ReadFile(path), IsOkAndHolds("a\nb\n"));
}

TEST(MakeDirectories, MakesParentsAndAcceptsWhatIsThere) {
  const std::string path = JoinPath(MakeFolder(), "a/b/c");

  EXPECT_THAT(MakeDirectories(path), IsOk());
  EXPECT_THAT(MakeDirectories(path), IsOk());

  EXPECT_TRUE(FileExists(path));
}

TEST(MakeDirectories, RefusesAFileInTheWay) {
  const std::string path = JoinPath(MakeFolder(), "f");
  ASSERT_THAT(WriteFileAtomically(path, ""), IsOk());

  EXPECT_THAT(MakeDirectories(path),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("cannot create folder " + path)));
  EXPECT_THAT(MakeDirectories(JoinPath(path, "below")),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("Not a directory")));
}

TEST(ListDirectory, SortsNames) {
  const std::string folder = MakeFolder();
  for (const char* name : {"b", "c", "a"}) {
    ASSERT_THAT(WriteFileAtomically(JoinPath(folder, name), ""), IsOk());
  }

  EXPECT_THAT(ListDirectory(folder), IsOkAndHolds(ElementsAre("a", "b", "c")));
}

TEST(ListDirectory, NamesTheFolderThatIsMissing) {
  EXPECT_THAT(ListDirectory("/nowhere"),
              StatusIs(absl::StatusCode::kNotFound,
                       "cannot list /nowhere: No such file or directory"));
}

TEST(FileSize, CountsBytesAndRefusesFolders) {
  const std::string folder = MakeFolder();
  const std::string path = JoinPath(folder, "f");
  ASSERT_THAT(WriteFileAtomically(path, "12345"), IsOk());

  EXPECT_THAT(FileSize(path), IsOkAndHolds(5));
  EXPECT_THAT(FileSize(folder),
              StatusIs(absl::StatusCode::kFailedPrecondition));
  EXPECT_THAT(FileSize(path + "x"), StatusIs(absl::StatusCode::kNotFound));
}

TEST(RemoveRecursively, RemovesATreeAndAcceptsNothing) {
  const std::string folder = MakeFolder();
  ASSERT_THAT(MakeDirectories(JoinPath(folder, "a/b")), IsOk());
  ASSERT_THAT(WriteFileAtomically(JoinPath(folder, "a/b/f"), ""), IsOk());

  EXPECT_THAT(RemoveRecursively(JoinPath(folder, "a")), IsOk());
  EXPECT_THAT(RemoveRecursively(JoinPath(folder, "a")), IsOk());

  EXPECT_THAT(ListDirectory(folder), IsOkAndHolds(IsEmpty()));
}

TEST(JoinPath, PutsExactlyOneSlashBetween) {
  EXPECT_EQ(JoinPath("a", "b"), "a/b");
  EXPECT_EQ(JoinPath("a/", "b"), "a/b");
  EXPECT_EQ(JoinPath("a", "/b"), "a/b");
  EXPECT_EQ(JoinPath("/", "b"), "/b");
  EXPECT_EQ(JoinPath("", "b"), "b");
}

TEST(DirectoryLock, RefusesASecondHolderAndNamesTheFirst) {
  const std::string folder = MakeFolder();
  auto first = DirectoryLock::Acquire(folder);
  ASSERT_THAT(first, IsOk());

  EXPECT_THAT(DirectoryLock::Acquire(folder),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       absl::StrCat("folder ", folder, " is in use by process ",
                                    getpid())));
}

TEST(DirectoryLock, IsFreeAgainOnceReleased) {
  const std::string folder = MakeFolder();
  ASSERT_THAT(DirectoryLock::Acquire(folder), IsOk());

  EXPECT_THAT(DirectoryLock::Acquire(folder), IsOk());
}

}  // namespace
}  // namespace sinew
