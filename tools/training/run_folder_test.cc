#include "tools/training/run_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <string>

#include "absl/strings/str_cat.h"
#include "common/config/recipe.h"
#include "common/files.h"
#include "common/testing/matchers.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;

std::string NewRun(const std::string& name) {
  return JoinPath(getenv("TEST_TMPDIR"), name);
}

v1::Recipe MakeRecipe(int epochs) {
  v1::Recipe recipe;
  recipe.mutable_ppo()->set_epochs(epochs);
  return WithDefaults(recipe);
}

TEST(RunFolderTest, WritesTheConfiguration) {
  const auto folder = RunFolder::Open(NewRun("config"), MakeRecipe(2));
  ASSERT_THAT(folder, IsOk());

  const auto text = ReadFile((*folder)->config());
  ASSERT_THAT(text, IsOk());
  EXPECT_EQ(*text, PrintRecipe(MakeRecipe(2)));
}

TEST(RunFolderTest, KeepsASecondLearnerOut) {
  const std::string run = NewRun("locked");
  const auto first = RunFolder::Open(run, MakeRecipe(2));
  ASSERT_THAT(first, IsOk());

  EXPECT_THAT(RunFolder::Open(run, MakeRecipe(2)),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr(run)));
}

TEST(RunFolderTest, RefusesAnotherRecipeOnceThereAreStates) {
  const std::string run = NewRun("other");
  ASSERT_THAT(RunFolder::Open(run, MakeRecipe(2)), IsOk());
  const std::string artifacts = JoinPath(run, "checkpoints/artifacts");
  ASSERT_THAT(MakeDirectories(artifacts), IsOk());
  ASSERT_THAT(WriteFileAtomically(JoinPath(artifacts, "state-00000001"), ""),
              IsOk());

  EXPECT_THAT(RunFolder::Open(run, MakeRecipe(3)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr(run), HasSubstr("ppo.epochs: 2 -> 3"))));
  EXPECT_THAT(RunFolder::Open(run, MakeRecipe(2)), IsOk());
}

TEST(RunFolderTest, TakesAnotherRecipeWhileThereAreNone) {
  const std::string run = NewRun("fresh");
  ASSERT_THAT(RunFolder::Open(run, MakeRecipe(2)), IsOk());

  EXPECT_THAT(RunFolder::Open(run, MakeRecipe(3)), IsOk());
}

}  // namespace
}  // namespace sinew::tools
