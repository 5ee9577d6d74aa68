#include "tools/training/run_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <string>

#include "absl/strings/str_cat.h"
#include "common/config/recipe.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/status_macros.h"
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

// Opens the folder and writes the recipe, as a run does; with states elsewhere
// of the recipe of `trained_epochs`, if that is not 0.
absl::Status Begin(const std::string& run, int epochs, int trained_epochs = 0) {
  SINEW_ASSIGN_OR_RETURN(const auto folder,
                         RunFolder::Open(run, MakeRecipe(epochs)));
  const std::string trained_with =
      trained_epochs > 0 ? Sha256Hex(PrintRecipe(MakeRecipe(trained_epochs)))
                         : "";
  return folder->WriteConfig(MakeRecipe(epochs), trained_with);
}

std::string ConfigOf(const std::string& run) {
  return ReadFile(JoinPath(run, "config.textproto")).value_or("none");
}

TEST(RunFolderTest, WritesTheConfiguration) {
  const std::string run = NewRun("config");
  ASSERT_THAT(RunFolder::Open(run, MakeRecipe(2)), IsOk());
  EXPECT_EQ(ConfigOf(run), "none");

  ASSERT_THAT(Begin(run, 2), IsOk());

  EXPECT_EQ(ConfigOf(run), PrintRecipe(MakeRecipe(2)));
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
  ASSERT_THAT(Begin(run, 2), IsOk());
  const std::string artifacts = JoinPath(run, "checkpoints/artifacts");
  ASSERT_THAT(MakeDirectories(artifacts), IsOk());
  ASSERT_THAT(WriteFileAtomically(JoinPath(artifacts, "state-00000001"), ""),
              IsOk());

  EXPECT_THAT(RunFolder::Open(run, MakeRecipe(3)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr(run), HasSubstr("ppo.epochs: 2 -> 3"))));
  EXPECT_THAT(Begin(run, 2), IsOk());
}

TEST(RunFolderTest, KeepsTheConfigurationOfStatesThatAreElsewhere) {
  const std::string run = NewRun("elsewhere");
  ASSERT_THAT(Begin(run, 2), IsOk());

  EXPECT_THAT(Begin(run, 3, /*trained_epochs=*/2),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr(run), HasSubstr("ppo.epochs: 2 -> 3"))));

  EXPECT_EQ(ConfigOf(run), PrintRecipe(MakeRecipe(2)));
  EXPECT_THAT(Begin(run, 2, /*trained_epochs=*/2), IsOk());
}

TEST(RunFolderTest, IsNotSpoiltByAWrongRecipeForStatesElsewhere) {
  const std::string run = NewRun("new");

  EXPECT_THAT(Begin(run, 3, /*trained_epochs=*/2),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("expected the recipe of the training state")));

  EXPECT_EQ(ConfigOf(run), "none");
  EXPECT_THAT(Begin(run, 2, /*trained_epochs=*/2), IsOk());
}

TEST(RunFolderTest, TakesAnotherRecipeWhileThereAreNone) {
  const std::string run = NewRun("fresh");
  ASSERT_THAT(Begin(run, 2), IsOk());

  EXPECT_THAT(Begin(run, 3), IsOk());
  EXPECT_EQ(ConfigOf(run), PrintRecipe(MakeRecipe(3)));
}

}  // namespace
}  // namespace sinew::tools
