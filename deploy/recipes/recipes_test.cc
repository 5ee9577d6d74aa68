// What every shipped recipe must be.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "common/config/recipe.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "common/workspace_files.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew {
namespace {

using ::sinew::testing::IsOk;

class RecipesTest : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    const auto path =
        FindWorkspaceFile("deploy/recipes/" + GetParam() + ".textproto");
    ASSERT_THAT(path, IsOk());
    const auto text = ReadFile(*path);
    ASSERT_THAT(text, IsOk());
    auto recipe = ParseRecipe(*text, *path);
    ASSERT_THAT(recipe, IsOk());
    recipe_ = WithDefaults(*std::move(recipe));
  }

  v1::Recipe recipe_;
};

TEST_P(RecipesTest, IsValidAndNamedAsItsFile) {
  EXPECT_EQ(recipe_.name(), GetParam());
  EXPECT_THAT(ValidateRecipe(recipe_), IsOk());
}

INSTANTIATE_TEST_SUITE_P(All, RecipesTest,
                         ::testing::Values("phc_plus", "phc_plus_g1",
                                           "track_clip", "track_library"),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace sinew
