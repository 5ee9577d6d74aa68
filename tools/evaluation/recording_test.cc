// Recordings of starts from the floor.
#include "tools/evaluation/recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "actor/fallen_evaluation.h"
#include "common/files.h"
#include "common/stop.h"
#include "common/testing/matchers.h"
#include "sim/world/fallen_states.h"
#include "sim/world/testing/toy_world.h"
#include "tools/evaluation/bundle_subject.h"
#include "tools/evaluation/fallen_figures.h"
#include "tools/evaluation/rollout_pool.h"
#include "tools/evaluation/testing/written_bundle.h"

namespace sinew::evaluation {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

using FallenRecording = testing::WrittenBundle;

TEST_F(FallenRecording, IsRecordedBesideAReferenceThatStandsAtFirst) {
  Write();
  const auto loaded = LoadBundleSubject(bundle_, motions_, 3);
  ASSERT_THAT(loaded, IsOk());

  const auto recording =
      RecordFallen(loaded->subject, 2, /*get_up=*/false, StopToken());

  ASSERT_THAT(recording, IsOk());
  const int nq = recording->nq;
  ASSERT_EQ(recording->frames(), 166);  // 5.5 s at 30 Hz, and the start
  ASSERT_EQ(recording->reference.size(), recording->simulated.size());
  const std::vector<double> clip = ReferencePoses(
      loaded->subject.character(), loaded->subject.library(), 0, 0, 77);
  const std::pair<int, int> frames[] = {{0, 0},  {1, 1},  {90, 1},
                                        {91, 1}, {92, 2}, {165, 75}};
  for (const auto& [frame, of_clip] : frames) {
    for (int i = 0; i < nq; ++i) {
      EXPECT_EQ(recording->reference[frame * nq + i], clip[of_clip * nq + i])
          << frame;
    }
  }
  // That state, below the reference's root, and not yet moved by the policy.
  const auto toy = world::testing::MakeToyWorld();
  const auto states =
      MakeFallenStates(JoinPath(toy.folder, "character.textproto"), 3);
  ASSERT_THAT(states, IsOk());
  const double* body = recording->simulated.data();
  EXPECT_DOUBLE_EQ(body[0], clip[0]);
  EXPECT_DOUBLE_EQ(body[1], clip[1]);
  for (int i = 2; i < nq; ++i) {
    EXPECT_NEAR(body[i], (*states)->qpos(2)[i], 1e-12) << i;
  }
  EXPECT_NE((*states)->qpos(1)[7], (*states)->qpos(2)[7]);
  const auto starts =
      actor::FallenStarts(loaded->subject.assets->task(), kLateSeconds);
  ASSERT_THAT(starts, IsOk());
  const auto results =
      RunStarts(loaded->subject.assets, *loaded->subject.policy, {(*starts)[2]},
                /*threads=*/1, StopToken());
  ASSERT_THAT(results, IsOk());
  EXPECT_EQ(recording->survived, results->front().success());
}

// All clips are there for it, also those that training drew no starts from.
TEST_F(FallenRecording, IsRecordedBesideAGetUpIfAskedFor) {
  v1::Recipe recipe = world::testing::ToyRecipe();
  recipe.mutable_task()->mutable_start()->add_only_clips("tumble");
  Write(recipe, world::testing::ToyClips::kWithGetUp);
  const auto loaded = LoadBundleSubject(bundle_, motions_, 3);
  ASSERT_THAT(loaded, IsOk());

  const auto recording =
      RecordFallen(loaded->subject, 2, /*get_up=*/true, StopToken());

  ASSERT_THAT(recording, IsOk());
  // The start, 20 steps in which it stands, 13 to 19 frames of the clip, and
  // what it goes on with.
  ASSERT_EQ(recording->frames(), 166);
  ASSERT_EQ(recording->reference.size(), recording->simulated.size());
  const auto height = [&](int frame) {
    return recording->reference[frame * recording->nq + 2];
  };
  EXPECT_LT(height(0), 0.8 * 0.44);
  EXPECT_EQ(height(20), height(1));
  EXPECT_GT(height(22), height(20));
  EXPECT_GT(height(33), height(22));
  // Then as "turn", whose height comes round with its 24 frames.
  double least = 1, most = 0;
  for (int frame = 60; frame < 84; ++frame) {
    EXPECT_NEAR(height(frame + 24), height(frame), 1e-6) << frame;
    least = std::min(least, height(frame));
    most = std::max(most, height(frame));
  }
  EXPECT_GT(most - least, 0.005);
  // The body goes on where it is; the reference begins anew at its place.
  for (int frame = 1; frame < recording->frames(); ++frame) {
    const double* now = recording->simulated.data() + frame * recording->nq;
    const double* before = now - recording->nq;
    EXPECT_LT(std::hypot(now[0] - before[0], now[1] - before[1]), 0.05)
        << frame;
    double turned = 0;  // of unit quaternions
    for (int i = 3; i < 7; ++i) turned += now[i] * before[i];
    EXPECT_GT(std::abs(turned), 0.99) << frame;
  }
  const auto starts =
      actor::GetUpStarts(loaded->subject.assets->task(), kLateSeconds);
  ASSERT_THAT(starts, IsOk());
  const auto results =
      RunStarts(loaded->subject.assets, *loaded->subject.policy, {(*starts)[2]},
                /*threads=*/1, StopToken());
  ASSERT_THAT(results, IsOk());
  ASSERT_EQ(results->front().carried_size(), 1);
  const int last = results->front().carried(0).after_frames();
  const double* body = recording->simulated.data() + last * recording->nq;
  const double* next = recording->reference.data() + (last + 1) * recording->nq;
  EXPECT_LT(std::hypot(body[0] - next[0], body[1] - next[1]), 0.03);
}

TEST_F(FallenRecording, IsRecordedUntilThereIsNothingToGoOnWith) {
  Write(world::testing::ToyRecipe(), world::testing::ToyClips::kWithGetUp);
  for (const int other_than_sway : {0, 2}) {
    world::testing::LeaveOutOnDisk(other_than_sway, motions_);
  }
  const auto loaded = LoadBundleSubject(bundle_, motions_, 3);
  ASSERT_THAT(loaded, IsOk());

  const auto recording =
      RecordFallen(loaded->subject, 2, /*get_up=*/true, StopToken());

  ASSERT_THAT(recording, IsOk());
  // The start, 20 steps in which it stands, and 13 to 19 frames of the clip.
  EXPECT_GE(recording->frames(), 34);
  EXPECT_LE(recording->frames(), 40);
  EXPECT_EQ(recording->reference.size(), recording->simulated.size());
  EXPECT_FALSE(recording->survived);
}

TEST_F(FallenRecording, HasNoRecordingOfAStateThatIsNone) {
  Write();
  const auto loaded = LoadBundleSubject(bundle_, motions_, 3);
  ASSERT_THAT(loaded, IsOk());

  for (const int state : {-1, 3}) {
    EXPECT_THAT(
        RecordFallen(loaded->subject, state, /*get_up=*/false, StopToken())
            .status(),
        StatusIs(absl::StatusCode::kInvalidArgument,
                 HasSubstr(absl::StrCat("fallen state: expected 0 to 2, found ",
                                        state))));
  }
}

}  // namespace
}  // namespace sinew::evaluation
