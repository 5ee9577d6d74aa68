#include "learner/distillation/student_networks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "common/testing/matchers.h"
#include "learner/distillation/testing/student_recipe.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;

// Column j of 4 rows has mean j and variance j + 1.
Moments Different() {
  Moments moments(kObservation);
  moments.count = 4;
  for (int j = 0; j < kObservation; ++j) {
    moments.mean[j] = j;
    moments.squares[j] = 4 * (j + 1);
  }
  return moments;
}

TEST(StudentNetworks, PutEachColumnIntoTheNormaliserThatSeesIt) {
  auto student = MakeStudent(StudentRecipe(), kObservation, kOwn, kAction);
  ASSERT_THAT(student, IsOk());

  WriteNormalisers(Different(), student->weights);

  for (int j = 0; j < kObservation; ++j) {
    const std::string prefix = j < kOwn ? "normaliser/own" : "normaliser/goal";
    const int place = j < kOwn ? j : j - kOwn;
    EXPECT_EQ(student->weights.at(prefix + "/mean").float32()[place], j);
    EXPECT_NEAR(student->weights.at(prefix + "/inverse_std").float32()[place],
                1 / std::sqrt(j + 1.0), 1e-6);
  }
}

TEST(StudentNetworks, InheritTheColumnsInTheirOrder) {
  for (const v1::Recipe& recipe : {StudentRecipe(), PlainStudentRecipe()}) {
    auto student = MakeStudent(recipe, kObservation, kOwn, kAction);
    ASSERT_THAT(student, IsOk());
    WriteNormalisers(Different(), student->weights);

    Moments inherited(kObservation);
    InheritNormalisers(student->weights, /*count=*/10, inherited);

    EXPECT_EQ(inherited.count, 10);
    ASSERT_EQ(inherited.mean.size(), static_cast<size_t>(kObservation));
    ASSERT_EQ(inherited.squares.size(), static_cast<size_t>(kObservation));
    for (int j = 0; j < kObservation; ++j) {
      EXPECT_EQ(inherited.mean[j], j);
      EXPECT_NEAR(inherited.squares[j], 10 * (j + 1), 1e-4);
    }
  }
}

}  // namespace
}  // namespace sinew::learner
