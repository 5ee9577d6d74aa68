#include "common/output_file.h"

#include "absl/status/status.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "common/testing/test_files.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::sinew::testing::TestPath;
using ::testing::HasSubstr;

TEST(CheckOutputFile, SaysWhereAFileCouldNotBeWritten) {
  ASSERT_THAT(MakeDirectories(TestPath("folder")), IsOk());
  ASSERT_THAT(WriteFileAtomically(TestPath("file"), "x"), IsOk());

  EXPECT_THAT(CheckOutputFile("here"), IsOk());
  EXPECT_THAT(CheckOutputFile(TestPath("file")), IsOk());
  EXPECT_THAT(CheckOutputFile(TestPath("folder/new")), IsOk());
  EXPECT_THAT(CheckOutputFile(TestPath("folder")),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("expected a file to write, found a folder")));
  EXPECT_THAT(CheckOutputFile(TestPath("no/new")),
              StatusIs(absl::StatusCode::kNotFound));
  EXPECT_THAT(CheckOutputFile(TestPath("file/new")),
              StatusIs(absl::StatusCode::kFailedPrecondition));
}

}  // namespace
}  // namespace sinew
