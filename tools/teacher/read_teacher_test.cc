#include "tools/teacher/read_teacher.h"

#include <algorithm>
#include <string>
#include <vector>

#include "common/files.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "sim/world/action.h"
#include "sim/world/testing/toy_world.h"
#include "teacher/local_annotator.h"

namespace sinew::teacher {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;

// The whole way, for a bundle around the body's own joints, whose base is q:
// what an actor would execute is what the teacher answers.
TEST(ReadTeacher, AnswersWithWhatAnActorWouldExecute) {
  v1::Recipe recipe = world::testing::ToyRecipe();
  recipe.mutable_task()->mutable_action()->set_placement(
      v1::Action::PLACEMENT_AROUND_CURRENT);
  const world::testing::ToyWorld toy = world::testing::MakeToyWorld(recipe);
  const std::string directory = JoinPath(toy.folder, "bundle");
  ASSERT_THAT(bundle::WriteBundle(bundle::testing::ToyContent(toy, /*gain=*/3),
                                  directory),
              IsOk());

  const auto policy = ReadTeacher(directory);
  ASSERT_THAT(policy, IsOk());
  const auto annotator = LocalAnnotator::Create(*policy, 1);
  ASSERT_THAT(annotator, IsOk());
  const auto width =
      static_cast<size_t>((*annotator)->description().observation_width());
  std::vector<float> observation(width);
  for (size_t i = 0; i < width; ++i) {
    observation[i] = static_cast<float>(i % 5) - 2;
  }
  const std::vector<double> q = {0.1, -0.2, 0.3, -0.4};
  std::vector<double> targets(4), executed(4);
  ASSERT_THAT((*annotator)
                  ->Annotate({.observations = observation, .bases = q},
                             absl::MakeSpan(targets)),
              IsOk());

  const auto pack =
      policy::PackWeights(policy->graph, "policy", policy->weights);
  ASSERT_THAT(pack, IsOk());
  const auto executor = policy::Executor::Create(*pack, 1).value();
  std::copy(observation.begin(), observation.end(),
            executor->input(executor->input_index("observation")).begin());
  executor->Run(1);
  world::ActionLaw(toy.recipe.task().action(), toy.character->joints())
      .Target(q, /*next=*/nullptr, executor->tap(executor->tap_index("action")),
              absl::MakeSpan(executed));
  EXPECT_EQ(targets, executed);
}

TEST(ReadTeacher, NamesAFolderThatIsNone) {
  EXPECT_THAT(ReadTeacher("/nowhere"), StatusIs(absl::StatusCode::kNotFound));
}

}  // namespace
}  // namespace sinew::teacher
