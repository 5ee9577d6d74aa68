#include "common/workspace_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/status/status.h"
#include "common/files.h"
#include "common/testing/matchers.h"

namespace sinew {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(WorkspaceFiles, FindsAFileThatTheProgramWasBuiltWith) {
  const auto path = FindWorkspaceFile("common/README.md");

  ASSERT_THAT(path, IsOk());
  EXPECT_THAT(ReadFile(*path), IsOk());
}

TEST(WorkspaceFiles, SaysWhereItLookedForAFileThatIsNotThere) {
  EXPECT_THAT(FindWorkspaceFile("common/no_such_file"),
              StatusIs(absl::StatusCode::kNotFound,
                       AllOf(HasSubstr("no file common/no_such_file, looked"),
                             HasSubstr(WorkspaceRoots().front()))));
}

}  // namespace
}  // namespace sinew
