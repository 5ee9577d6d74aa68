#include "common/mapped_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_split.h"
#include "common/files.h"
#include "common/testing/matchers.h"

namespace sinew {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

std::string Path(const std::string& name) {
  return JoinPath(::testing::TempDir(), name);
}

TEST(MappedFile, HasTheFilesBytes) {
  const std::string content = "first" + std::string(10000, 'x') + "last";
  ASSERT_THAT(WriteFileAtomically(Path("some"), content), IsOk());

  const auto file = MappedFile::Open(Path("some"));

  ASSERT_THAT(file, IsOk());
  EXPECT_EQ((*file)->bytes(), content);
}

TEST(MappedFile, IsSharedWithOtherProcessesAndReadOnly) {
  ASSERT_THAT(WriteFileAtomically(Path("shared"), "content"), IsOk());
  const auto file = MappedFile::Open(Path("shared"));
  ASSERT_THAT(file, IsOk());

  const auto maps = ReadFile("/proc/self/maps");

  ASSERT_THAT(maps, IsOk());
  std::string found;
  for (const std::string& line :
       std::vector<std::string>(absl::StrSplit(*maps, '\n'))) {
    if (absl::EndsWith(line, "/shared")) found = line;
  }
  EXPECT_THAT(found, HasSubstr(" r--s "));
}

TEST(MappedFile, KeepsItsContentWhenTheFileIsReplacedByAShorterOne) {
  const std::string old_content(20000, 'o');
  ASSERT_THAT(WriteFileAtomically(Path("replaced"), old_content), IsOk());
  const auto old_file = MappedFile::Open(Path("replaced"));
  ASSERT_THAT(old_file, IsOk());

  ASSERT_THAT(WriteFileAtomically(Path("replaced"), "new"), IsOk());

  EXPECT_EQ((*old_file)->bytes(), old_content);
  const auto new_file = MappedFile::Open(Path("replaced"));
  ASSERT_THAT(new_file, IsOk());
  EXPECT_EQ((*new_file)->bytes(), "new");
}

TEST(MappedFile, IsEmptyForAnEmptyFile) {
  ASSERT_THAT(WriteFileAtomically(Path("empty"), ""), IsOk());
  const auto file = MappedFile::Open(Path("empty"));
  ASSERT_THAT(file, IsOk());
  EXPECT_EQ((*file)->bytes(), "");
}

TEST(MappedFile, NamesThePathThatCannotBeMapped) {
  EXPECT_THAT(MappedFile::Open(Path("nowhere")),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("nowhere")));
  EXPECT_THAT(MappedFile::Open(::testing::TempDir()),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("not a regular file")));
  // Nobody writes to it.
  ASSERT_EQ(mkfifo(Path("pipe").c_str(), 0600), 0);
  EXPECT_THAT(MappedFile::Open(Path("pipe")),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("not a regular file")));
}

}  // namespace
}  // namespace sinew
