// Teachers that observe less than their student.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "tools/training/run_teacher.h"
#include "tools/training/task_setup.h"
#include "tools/training/testing/several_teachers.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using testing::ClipNames;
using ::testing::HasSubstr;
using testing::SeveralTeachers;

// The student sees its previous target as well, which no teacher does.
TEST(NarrowTeacherTest, LabelsByTheColumnsThatItKnows) {
  SeveralTeachers run;
  const std::vector<std::string> clips = ClipNames(*run.setup.library);
  const std::string first = run.Bundle("first", {clips[0]}, /*gain=*/0.3);
  const std::string rest =
      run.Bundle("rest", {clips.begin() + 1, clips.end()}, /*gain=*/0.6);
  const auto narrow = run.Open({first, rest});
  ASSERT_THAT(narrow, IsOk());
  std::vector<float> seen(run.setup.observation_width);
  for (size_t i = 0; i < seen.size(); ++i) {
    seen[i] = 0.01F * static_cast<float>(i);
  }
  const std::vector<double> of_first = run.Target(**narrow, 0, seen);
  const std::vector<double> of_rest = run.Target(**narrow, 1, seen);
  ASSERT_NE(of_first, of_rest);
  const int own = run.setup.self_observation_width;
  v1::Observation& observation =
      *run.recipe.mutable_task()->mutable_observation();
  observation.clear_blocks();
  for (const auto block : {v1::Observation::BLOCK_SELF_JOINT_SPACE,
                           v1::Observation::BLOCK_PREVIOUS_TARGET,
                           v1::Observation::BLOCK_REFERENCE_DIFFERENCE}) {
    observation.add_blocks(block);
  }
  const auto set_up =
      SetUpTask(run.recipe, JoinPath(run.toy.folder, "character.textproto"),
                run.toy.library_folder);
  ASSERT_THAT(set_up, IsOk());
  run.setup = *set_up;
  // What the previous target is, the teachers do not mind.
  std::vector<float> wide = seen;
  wide.insert(wide.begin() + own, run.setup.action_width, 7.0F);
  ASSERT_EQ(static_cast<int>(wide.size()), run.setup.observation_width);

  const auto both = run.Open({first, rest});
  ASSERT_THAT(both, IsOk());
  EXPECT_EQ(run.Target(**both, 0, wide), of_first);
  EXPECT_EQ(run.Target(**both, 1, wide), of_rest);
  const auto alone = run.Open({rest});
  ASSERT_THAT(alone, IsOk());
  EXPECT_EQ(run.Target(**alone, 0, wide), of_rest);
  // By what it sees an actor could not let it act.
  run.recipe.mutable_distillation()->set_teacher_share(0.25);
  EXPECT_THAT(run.Open({first}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("distillation.teacher_share"),
                             HasSubstr("does not observe all"))));
}

}  // namespace
}  // namespace sinew::tools
