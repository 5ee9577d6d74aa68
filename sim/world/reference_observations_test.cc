#include "sim/world/reference_observations.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <memory>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "common/testing/matchers.h"
#include "sim/character/model_ptr.h"
#include "sim/world/testing/library_maker.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::world {
namespace {

using ::sinew::testing::IsOk;
using v1::Observation;

v1::Recipe FullRecipe() {
  v1::Recipe recipe = testing::ToyRecipe();
  Observation& observation = *recipe.mutable_task()->mutable_observation();
  observation.clear_blocks();
  for (const auto block :
       {Observation::BLOCK_SELF_JOINT_SPACE,
        Observation::BLOCK_REFERENCE_DIFFERENCE,
        Observation::BLOCK_PREVIOUS_TARGET,
        Observation::BLOCK_REFERENCE_CONTACT, Observation::BLOCK_SELF_CONTACT,
        Observation::BLOCK_SELF_BODIES}) {
    observation.add_blocks(block);
  }
  observation.clear_frames_ahead();
  observation.add_frames_ahead(1);
  observation.add_frames_ahead(5);
  return recipe;
}

std::unique_ptr<TrackingTask> MakeTask(const testing::ToyWorld& world) {
  auto task =
      TrackingTask::Create(world.recipe, *world.character, *world.library);
  EXPECT_THAT(task, IsOk());
  return *std::move(task);
}

std::unique_ptr<const ReferenceObservations> Open(const TrackingTask& task,
                                                  const std::string& folder) {
  auto observations = ReferenceObservations::Open(task, folder);
  EXPECT_THAT(observations, IsOk());
  return *std::move(observations);
}

TEST(ReferenceObservations, AreWhatTheTaskObservesOfABodyOnTheReference) {
  const testing::ToyWorld world = testing::MakeToyWorld(FullRecipe());
  const auto task = MakeTask(world);
  const auto observations = Open(*task, testing::NewFolder());
  const std::vector<std::string> names = task->ObservationNames();
  const auto work = task->MakeWorkspace();
  const character::DataPtr data(mj_makeData(world.character->model()));
  std::vector<float> observed(task->observation_width());
  std::vector<double> target(task->action_width());

  ASSERT_EQ(observations->width(), task->observation_width());
  for (int clip = 0; clip < world.library->num_clips(); ++clip) {
    for (int t = 0; t < world.library->clip(clip).num_frames(); ++t) {
      const Episode episode = {.clip = clip, .start_frame = t};
      task->Reset(episode, nullptr, data.get(), absl::MakeSpan(target),
                  work.get());
      for (int j = 0; j < task->action_width(); ++j) {
        target[j] = data->qpos[world.character->joints()[j].qpos_address];
      }
      task->Observe(data.get(), episode, target, absl::MakeSpan(observed),
                    work.get());
      const absl::Span<const float> row = observations->Row(clip, t);
      for (size_t i = 0; i < names.size(); ++i) {
        // The clip's label, not the geometry's.
        if (absl::StartsWith(names[i], "self/contact")) {
          EXPECT_EQ(row[i], world.library->frame(clip, t).contact[0]);
          continue;
        }
        // Bodies pass through float32 in the library.
        EXPECT_NEAR(row[i], observed[i], 2e-4)
            << "clip " << clip << " frame " << t << " " << names[i];
      }
    }
  }
}

TEST(ReferenceObservations, AreComputedOncePerLibraryAndRecipe) {
  const testing::ToyWorld world = testing::MakeToyWorld(FullRecipe());
  const auto task = MakeTask(world);
  const std::string folder = testing::NewFolder();

  EXPECT_FALSE(Open(*task, folder)->file().found());
  EXPECT_TRUE(Open(*task, folder)->file().found());

  testing::ToyWorld other = testing::MakeToyWorld(FullRecipe());
  other.recipe.mutable_task()->mutable_observation()->set_frames_ahead(1, 6);
  const auto changed = MakeTask(other);
  EXPECT_FALSE(Open(*changed, folder)->file().found());
  EXPECT_TRUE(Open(*changed, folder)->file().found());
}

}  // namespace
}  // namespace sinew::world
