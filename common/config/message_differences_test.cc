#include "common/config/message_differences.h"

#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew {
namespace {

TEST(MessageDifferences, NamesEveryFieldInALine) {
  v1::Recipe expected, found;
  expected.set_seed(1);
  found.set_seed(2);
  expected.mutable_physics()->set_physics_hz(120);
  found.mutable_physics()->set_physics_hz(240);

  const std::string differences = MessageDifferences(expected, found);

  EXPECT_THAT(differences, ::testing::HasSubstr("seed: 1 -> 2"));
  EXPECT_THAT(differences, ::testing::HasSubstr("; "));
  EXPECT_THAT(differences, ::testing::HasSubstr("physics_hz: 120 -> 240"));
  EXPECT_THAT(differences, ::testing::Not(::testing::HasSubstr("\n")));
}

TEST(MessageDifferences, AreNoneOfEqualMessages) {
  v1::Recipe recipe;
  recipe.set_seed(1);

  EXPECT_EQ(MessageDifferences(recipe, recipe), "");
}

}  // namespace
}  // namespace sinew
