// A student whose snapshots hold the teacher that acts in a share of episodes.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>

#include "absl/strings/match.h"
#include "common/policy/builder.h"
#include "common/policy/safetensors.h"
#include "common/policy/teacher_graph.h"
#include "common/testing/matchers.h"
#include "learner/distillation/distillation_learner.h"
#include "learner/distillation/testing/distillation_rig.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;

// A learner with a teacher of this seed beside its policy.
std::unique_ptr<DistillationLearner> MakeShared(SyntheticTeacher& annotator,
                                                uint64_t teacher_seed) {
  const policy::TrackingPolicyOptions network = {
      .observation_width = kObservation,
      .action_width = kAction,
      .network = PlainStudentRecipe().network()};
  const auto graph = policy::BuildTrackingPolicy(network);
  const auto weights = policy::InitialWeights(network, teacher_seed);
  EXPECT_THAT(graph.status(), IsOk());
  EXPECT_THAT(weights.status(), IsOk());
  auto learner = DistillationLearner::Create(
      StudentRecipe("distillation { teacher_share: 0.5 }"),
      {.observation_width = kObservation,
       .self_observation_width = kOwn,
       .action_width = kAction,
       .ranks = 2,
       .annotator = &annotator,
       .layout = StudentLayout(),
       .action_scale = StudentScale(),
       .add_graphs = [&](v1::PolicyGraph& all, TensorMap& all_weights) {
         return policy::AddTeacherGraph(*graph, *weights, all, all_weights);
       }});
  EXPECT_THAT(learner.status(), IsOk());
  return learner.ok() ? *std::move(learner) : nullptr;
}

// The teacher's weights; not none.
std::string TeacherBits(const Learner& learner) {
  TensorMap weights = learner.weights();
  std::erase_if(weights, [](const auto& one) {
    return !absl::StartsWith(one.first, policy::kTeacherPrefix);
  });
  EXPECT_FALSE(weights.empty());
  return SerializeSafetensors(weights);
}

bool HasTeacherGraph(const Learner& learner) {
  const auto& graphs = learner.graph().graphs();
  return std::any_of(graphs.begin(), graphs.end(), [](const auto& graph) {
    return graph.name() == policy::kTeacherGraph;
  });
}

TEST(TeacherShare, KeepsTheTeachersBitsWhileTheStudentLearns) {
  SyntheticTeacher annotator;
  const auto learner = MakeShared(annotator, 5);
  ASSERT_TRUE(HasTeacherGraph(*learner));
  const std::string teacher = TeacherBits(*learner);
  const std::string before = Bits(*learner);

  const auto segments = MakeVisited(0);
  ASSERT_THAT(learner->Update(SegmentPointers(segments), 0).status(), IsOk());

  EXPECT_NE(Bits(*learner), before);
  EXPECT_EQ(TeacherBits(*learner), teacher);
  v1::TrainingState state;
  learner->SaveCounters(state);
  const auto resumed = MakeShared(annotator, 5);
  ASSERT_THAT(
      resumed->Load(learner->SaveTensors(), state, learner->SaveChunks()),
      IsOk());
  EXPECT_EQ(TeacherBits(*resumed), teacher);
  EXPECT_EQ(Bits(*resumed), Bits(*learner));
}

TEST(TeacherShare, KeepsItsOwnTeacherWhenItBeginsWithAnothersWeights) {
  SyntheticTeacher annotator;
  const auto learner = MakeShared(annotator, 5);
  const auto other = MakeShared(annotator, 6);
  const std::string teacher = TeacherBits(*learner);
  ASSERT_NE(TeacherBits(*other), teacher);

  ASSERT_THAT(learner->InitFrom(other->weights()), IsOk());

  EXPECT_EQ(TeacherBits(*learner), teacher);
}

}  // namespace
}  // namespace sinew::learner
