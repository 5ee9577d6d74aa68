#include "common/policy/teacher_graph.h"

#include <memory>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/types/span.h"
#include "common/config/recipe.h"
#include "common/policy/builder.h"
#include "common/policy/executor.h"
#include "common/policy/safetensors.h"
#include "common/policy/validate.h"
#include "common/random/philox.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::policy {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

struct Policy {
  explicit Policy(uint64_t seed) {
    TrackingPolicyOptions options{.observation_width = 6, .action_width = 2};
    options.network = WithDefaults(v1::Recipe()).network();
    options.network.clear_policy_hidden();
    options.network.add_policy_hidden(8);
    graph = *BuildTrackingPolicy(options);
    weights = *InitialWeights(options, seed);
  }
  // Means of a graph for two rows.
  std::vector<float> Means(const std::string& name) const {
    auto executor = *Executor::Create(*PackWeights(graph, name, weights), 2);
    FillNormal({.seed = 9},
               executor->input(executor->input_index("observation")));
    executor->Run(2);
    const auto mean = executor->tap(executor->tap_index("mean"));
    return {mean.begin(), mean.end()};
  }

  v1::PolicyGraph graph;
  TensorMap weights;
};

TEST(TeacherGraph, ActsAsTheTeacherBesideTheStudent) {
  const Policy teacher(1);
  Policy student(2);
  const std::vector<float> own = student.Means("policy");

  ASSERT_THAT(AddTeacherGraph(teacher.graph, teacher.weights, student.graph,
                              student.weights),
              IsOk());

  EXPECT_THAT(ValidateGraph(student.graph, student.weights), IsOk());
  EXPECT_EQ(student.Means("teacher"), teacher.Means("policy"));
  EXPECT_EQ(student.Means("policy"), own);
  EXPECT_NE(own, teacher.Means("policy"));
}

TEST(TeacherGraph, FreezesItsParametersAndTakesNoOthers) {
  const Policy teacher(1);
  Policy student(2);
  const int before = student.graph.parameters_size();

  ASSERT_THAT(AddTeacherGraph(teacher.graph, teacher.weights, student.graph,
                              student.weights),
              IsOk());

  // Normaliser 2, two layers, standard deviation; no critic.
  EXPECT_EQ(student.graph.parameters_size(), before + 2 + 2 * 2 + 1);
  EXPECT_EQ(student.weights.size(), student.graph.parameters_size());
  for (const v1::Parameter& parameter : student.graph.parameters()) {
    if (!absl::StartsWith(parameter.name(), "teacher/")) continue;
    EXPECT_TRUE(parameter.frozen()) << parameter.name();
  }
}

TEST(TeacherGraph, RefusesASecondTeacherAndOneWithoutPolicy) {
  Policy teacher(1);
  Policy student(2);
  const auto add = [&] {
    return AddTeacherGraph(teacher.graph, teacher.weights, student.graph,
                           student.weights);
  };
  ASSERT_THAT(add(), IsOk());
  EXPECT_THAT(add(), StatusIs(absl::StatusCode::kInvalidArgument,
                              HasSubstr("expected no graph named teacher")));

  teacher.graph.mutable_graphs(0)->set_name("actor");
  EXPECT_THAT(
      add(), StatusIs(absl::StatusCode::kInvalidArgument,
                      HasSubstr("teacher: expected a graph named \"policy\"")));
  teacher.weights.clear();
  EXPECT_THAT(add(), StatusIs(absl::StatusCode::kInvalidArgument,
                              HasSubstr("teacher: weights: parameter ")));
}

}  // namespace
}  // namespace sinew::policy
