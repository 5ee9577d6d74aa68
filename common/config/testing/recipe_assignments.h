#ifndef SINEW_COMMON_CONFIG_TESTING_RECIPE_ASSIGNMENTS_H_
#define SINEW_COMMON_CONFIG_TESTING_RECIPE_ASSIGNMENTS_H_

#include <ostream>
#include <string>
#include <vector>

#include "common/config/recipe.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew::testing {

// Assignments first, then defaults, as for a recipe from a file.
inline v1::Recipe MakeRecipe(const std::vector<std::string>& assignments) {
  v1::Recipe recipe;
  for (const std::string& assignment : assignments) {
    EXPECT_THAT(SetRecipeField(recipe, assignment), IsOk());
  }
  return WithDefaults(recipe);
}

// Assignments that make a recipe invalid, and what is said of it: the end of
// the message, from the path of the field on.
struct Violation {
  std::vector<std::string> assignments;
  std::string expected;
};

inline void PrintTo(const Violation& violation, std::ostream* os) {
  *os << violation.assignments.front();
}

}  // namespace sinew::testing

#endif  // SINEW_COMMON_CONFIG_TESTING_RECIPE_ASSIGNMENTS_H_
