#include "learner/curriculum/curriculum.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/testing/matchers.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

// Two clips at 10 Hz: "loop" of 25 frames, "once" of 11 (10 startable).
v1::MotionLibrary MakeLibrary() {
  v1::MotionLibrary library;
  library.set_frames_per_second(10);
  auto& loop = *library.add_clips();
  loop.set_name("loop");
  loop.set_num_frames(25);
  loop.set_loops(true);
  auto& once = *library.add_clips();
  once.set_name("once");
  once.set_num_frames(11);
  return library;
}

std::unique_ptr<Curriculum> MakeCurriculum(v1::Start::Rule rule,
                                           double uniform_share = 0.1) {
  v1::Start start;
  start.set_rule(rule);
  start.set_bin_seconds(1);
  start.set_uniform_share(uniform_share);
  auto curriculum = Curriculum::Create(start, MakeLibrary());
  EXPECT_TRUE(curriculum.ok()) << curriculum.status();
  return *std::move(curriculum);
}

v1::EpisodeEnd MakeEpisode(int clip, int start, int steps, bool failed) {
  v1::EpisodeEnd episode;
  episode.set_clip(clip);
  episode.set_start_frame(start);
  episode.set_steps(steps);
  episode.set_reason(failed ? v1::EpisodeEnd::REASON_TERMINATED
                            : v1::EpisodeEnd::REASON_TIME_LIMIT);
  episode.set_mean_body_distance(0.2);
  return episode;
}

double TotalProbability(const v1::CurriculumTable& table) {
  double total = 0;
  for (const auto& bin : table.bins()) total += bin.probability();
  return total;
}

TEST(Curriculum, CutsClipsIntoBinsAndLeavesOutLastFrames) {
  auto curriculum = MakeCurriculum(v1::Start::RULE_UNIFORM);

  const auto& bins = curriculum->table().bins();

  // loop: 10 + 10 + 5, once: 10.
  ASSERT_EQ(bins.size(), 4);
  EXPECT_EQ(bins[2].first_frame(), 20);
  EXPECT_EQ(bins[2].num_frames(), 5);
  EXPECT_EQ(bins[3].clip(), 1);
  EXPECT_EQ(bins[3].num_frames(), 10);
  EXPECT_EQ(bins[3].last_seen(), -1);
  EXPECT_NEAR(bins[2].probability(), 5.0 / 35, 1e-12);
}

TEST(Curriculum, CountsFailuresWhereTheyHappenAndVisitsWhereTheyBegin) {
  auto curriculum = MakeCurriculum(v1::Start::RULE_BINS);

  // Begins in bin 0, fails at frame 5 + 28 = 33 of a loop of 25: frame 8.
  curriculum->Record({MakeEpisode(0, 15, 18, true)}, /*iteration=*/7);

  const auto& bins = curriculum->table().bins();
  EXPECT_EQ(bins[1].visits(), 1);
  EXPECT_EQ(bins[1].last_seen(), 7);
  EXPECT_DOUBLE_EQ(bins[1].mean_body_distance(), 0.2);
  EXPECT_EQ(bins[0].failures(), 1);  // (15 + 18) mod 25 = 8
  EXPECT_EQ(bins[1].failures(), 0);
}

TEST(Curriculum, FavoursBinsThatFailAndKeepsAFloorForOthers) {
  auto curriculum = MakeCurriculum(v1::Start::RULE_BINS, 0.2);
  std::vector<v1::EpisodeEnd> episodes(100, MakeEpisode(0, 0, 300, false));
  for (int i = 0; i < 100; ++i) episodes.push_back(MakeEpisode(1, 0, 3, true));

  curriculum->Record(episodes, 1);
  curriculum->Reweigh();

  const auto& table = curriculum->table();
  EXPECT_NEAR(TotalProbability(table), 1, 1e-9);
  EXPECT_GT(table.bins(3).probability(), 10 * table.bins(0).probability() / 3);
  EXPECT_GE(table.bins(0).probability(), 0.2 * 10 / 35);
}

TEST(Curriculum, IgnoresStatisticsUnderTheUniformRule) {
  auto curriculum = MakeCurriculum(v1::Start::RULE_UNIFORM);
  const auto before = curriculum->table();

  curriculum->Record({MakeEpisode(1, 0, 3, true)}, 1);
  curriculum->Reweigh();

  for (int i = 0; i < before.bins_size(); ++i) {
    EXPECT_EQ(curriculum->table().bins(i).probability(),
              before.bins(i).probability());
  }
}

TEST(Curriculum, RestoresATableAndRefusesOneOfOtherBins) {
  auto curriculum = MakeCurriculum(v1::Start::RULE_BINS);
  curriculum->Record({MakeEpisode(1, 0, 3, true)}, 1);
  curriculum->Reweigh();
  auto other = MakeCurriculum(v1::Start::RULE_BINS);

  ASSERT_THAT(other->Restore(curriculum->table()), IsOk());
  EXPECT_EQ(other->table().SerializeAsString(),
            curriculum->table().SerializeAsString());

  v1::CurriculumTable small;
  EXPECT_THAT(other->Restore(small),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("expected 4 bins of 10 frames, found 0")));
}

TEST(Curriculum, RefusesALibraryWithoutClips) {
  EXPECT_THAT(Curriculum::Create(v1::Start(), v1::MotionLibrary()),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("at least one clip")));
}

}  // namespace
}  // namespace sinew::learner
