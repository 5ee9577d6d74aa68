// What the importer makes, played by the task that trains on it: a body put on
// the reference frame after frame.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "common/config/recipe.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "sim/import/importer.h"
#include "sim/import/testing/made_clips.h"
#include "sim/motion/library.h"
#include "sim/world/tracking_task.h"

namespace sinew::world {
namespace {

using ::sinew::testing::IsOk;
using ::testing::Each;
using ::testing::FloatNear;

struct Playback {
  Playback() {
    auto loaded = character::Character::Load("humanoid", recipe.physics());
    EXPECT_THAT(loaded, IsOk());
    character = *std::move(loaded);
    std::vector<std::string> files = sinew::import::testing::RecordedClips();
    files.push_back(JoinPath(::testing::TempDir(), "march.txt"));
    EXPECT_THAT(
        WriteFileAtomically(files.back(), sinew::import::testing::MarchJson()),
        IsOk());
    const std::string folder = JoinPath(::testing::TempDir(), "library");
    std::vector<import::ClipReport> reports;
    EXPECT_THAT(
        sinew::import::ImportFiles(*character, files, {}, folder, &reports),
        IsOk());
    auto opened = motion::Library::Load(folder);
    EXPECT_THAT(opened, IsOk());
    library = *std::move(opened);
    auto created = TrackingTask::Create(recipe, *character, *library);
    EXPECT_THAT(created, IsOk());
    task = *std::move(created);
    work = task->MakeWorkspace();
    data.reset(mj_makeData(character->model()));
  }

  // Distance from the floor of the nearest geom of foot `f`, negative below.
  double FootHeight(size_t f) {
    mj_kinematics(character->model(), data.get());
    double nearest = 1;
    for (const int geom : character->foot_geoms()[f]) {
      nearest = std::min(
          nearest, mj_geomDistance(character->model(), data.get(),
                                   character->floor_geom(), geom, 1, nullptr));
    }
    return nearest;
  }

  v1::Recipe recipe = WithDefaults(v1::Recipe());
  std::unique_ptr<const character::Character> character;
  std::unique_ptr<const motion::Library> library;
  std::unique_ptr<TrackingTask> task;
  std::unique_ptr<TrackingTask::Workspace> work;
  character::DataPtr data;
};

TEST(ReferencePlayback, HasFullRewardAndNoErrorAndItsFeetMeetTheFloor) {
  Playback play;
  motion::ReferenceFrame frame(*play.library);
  for (int clip = 0; clip < play.library->num_clips(); ++clip) {
    const v1::ClipInfo& info = play.library->clip(clip);
    const int64_t frames =
        info.loops() ? 2 * info.num_frames() : info.num_frames() - 1;
    int bearing = 0;
    Episode episode{.clip = clip, .start_frame = 0};
    for (int64_t i = 1; i <= frames; ++i) {
      frame.Load(clip, i);
      SetReferencePose(*play.character, frame.view(), play.data.get());
      const StepResult result = play.task->Finish(
          play.data.get(), ActuationResult(), &episode, play.work.get());
      // Single precision of the stored frames is all that lies between.
      EXPECT_NEAR(result.reward, 1, 1e-4) << info.name() << " " << i;
      EXPECT_THAT(result.reward_terms, Each(FloatNear(1, 1e-4)));
      EXPECT_NEAR(result.mean_body_distance, 0, 1e-5) << info.name();
      EXPECT_FALSE(result.terminated);
      for (size_t f = 0; f < play.character->foot_bodies().size(); ++f) {
        EXPECT_GT(play.FootHeight(f), -0.015) << info.name() << " " << i;
        if (frame.view().contact[f] == 0) continue;
        ++bearing;
        EXPECT_LT(play.FootHeight(f), 0.03) << info.name() << " " << i;
      }
    }
    EXPECT_GT(bearing, 0) << info.name();
  }
}

}  // namespace
}  // namespace sinew::world
