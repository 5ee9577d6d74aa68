#include "actor/testing/student_rollout.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "actor/testing/rollout_rig.h"
#include "common/config/recipe.h"
#include "common/testing/matchers.h"

namespace sinew::actor::testing {
namespace {

// The toy's joints: range +-1.5 rad, margin 1.5.
constexpr double kEnd = 3;

}  // namespace

v1::Recipe StudentRecipe(const std::string& task,
                         const std::string& distillation) {
  auto recipe = ParseRecipe(
      absl::StrCat("task {", task, "} distillation {", distillation, "}"),
      "test");
  EXPECT_THAT(recipe, sinew::testing::IsOk());
  return WithDefaults(*recipe);
}

Rows::Rows(const v1::Segment& segment)
    : action(Column<float>(segment, "action")),
      mean(Column<float>(segment, "action_mean")),
      target(Column<double>(segment, "target")),
      base(Column<double>(segment, "base")),
      teacher_base(Column<double>(segment, "teacher_base")) {}

double Rows::Made(const std::vector<double>& bases, size_t i,
                  double scale) const {
  const double own = i % kJoints == 2 ? kOwnScale : scale;
  return std::clamp(bases[i] + own * action[i], -kEnd, kEnd);
}

}  // namespace sinew::actor::testing
