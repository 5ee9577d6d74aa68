#include "learner/curriculum/curriculum.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "common/testing/matchers.h"
#include "learner/curriculum/testing/curriculum_rig.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::vector<double> RecentPassages(const Curriculum& curriculum) {
  std::vector<double> values;
  for (const auto& bin : curriculum.table().bins()) {
    values.push_back(bin.recent_passages());
  }
  return values;
}

std::vector<double> RecentFailures(const Curriculum& curriculum) {
  std::vector<double> values;
  for (const auto& bin : curriculum.table().bins()) {
    values.push_back(bin.recent_failures());
  }
  return values;
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

  // Begins in bin 1, fails at frame 15 + 18 = 33 of a loop of 25: frame 8.
  curriculum->Record(MakeEpisode(0, 15, 18, true), /*iteration=*/7);

  const auto& bins = curriculum->table().bins();
  EXPECT_EQ(bins[1].visits(), 1);
  EXPECT_EQ(bins[1].last_seen(), 7);
  EXPECT_DOUBLE_EQ(bins[1].mean_body_distance(), 0.2);
  EXPECT_EQ(bins[0].failures(), 1);
  EXPECT_EQ(bins[1].failures(), 0);
}

TEST(Curriculum, FavoursBinsThatFailAndKeepsAFloorForOthers) {
  auto curriculum = MakeCurriculum(v1::Start::RULE_BINS, 0.2);
  std::vector<v1::EpisodeEnd> episodes(100, MakeEpisode(0, 0, 300, false));
  for (int i = 0; i < 100; ++i) episodes.push_back(MakeEpisode(1, 0, 3, true));

  for (const auto& episode : episodes) curriculum->Record(episode, 1);
  curriculum->Reweigh();

  const auto& table = curriculum->table();
  EXPECT_NEAR(TotalProbability(table), 1, 1e-9);
  EXPECT_GT(table.bins(3).probability(), 10 * table.bins(0).probability() / 3);
  EXPECT_GE(table.bins(0).probability(), 0.2 * 10 / 35);
}

TEST(Curriculum, IgnoresStatisticsUnderTheUniformRule) {
  auto curriculum = MakeCurriculum(v1::Start::RULE_UNIFORM);
  const auto before = curriculum->table();

  curriculum->Record(MakeEpisode(1, 0, 3, true), 1);
  curriculum->Reweigh();

  for (int i = 0; i < before.bins_size(); ++i) {
    EXPECT_EQ(curriculum->table().bins(i).probability(),
              before.bins(i).probability());
  }
}

TEST(Curriculum, CountsEveryPassageThroughABin) {
  auto curriculum = MakeAdaptive(MakeLibrary());

  // From frame 5 of the loop over its end, at 25, to frame 5 + 27 = 32: bins
  // 0, 1, 2 and 0 again. The other clip to its end.
  curriculum->Record(MakeEpisode(0, 5, 27, false), 1);
  curriculum->Record(MakeEpisode(1, 4, 6, false), 1);

  EXPECT_THAT(RecentPassages(*curriculum), ElementsAre(2, 1, 1, 1));
  EXPECT_THAT(RecentFailures(*curriculum), ElementsAre(0, 0, 0, 0));
}

TEST(Curriculum, BlamesWhatLiesShortlyBeforeAFailure) {
  auto curriculum = MakeAdaptive(MakeLibrary());

  // Fails at frame 22 of bin 2; the five frames before begin with 17, and
  // frames 17 to 19 of 10 to 19 lie in bin 1.
  curriculum->Record(MakeEpisode(0, 2, 20, true), 1);

  EXPECT_THAT(RecentPassages(*curriculum), ElementsAre(1, 1, 1, 0));
  EXPECT_THAT(RecentFailures(*curriculum), ElementsAre(0, 0.3, 1, 0));
}

TEST(Curriculum, BlamesNothingBeforeTheStart) {
  auto curriculum = MakeAdaptive(MakeLibrary());

  // Begins at 18: frames 18 and 19 of bin 1, both in the window.
  curriculum->Record(MakeEpisode(0, 18, 4, true), 1);
  // Over the end of the loop: frame 24 is of bin 2, 26 of bin 0.
  curriculum->Record(MakeEpisode(0, 24, 2, true), 1);

  EXPECT_THAT(RecentFailures(*curriculum), ElementsAre(1, 1, 2, 0));
  EXPECT_THAT(RecentPassages(*curriculum), ElementsAre(1, 1, 2, 0));
}

TEST(Curriculum, TakesEpisodesThatDivergeAsFailedInRates) {
  auto curriculum = MakeAdaptive(MakeLibrary());
  v1::EpisodeEnd episode = MakeEpisode(0, 2, 20, false);
  episode.set_reason(v1::EpisodeEnd::REASON_DIVERGED);

  curriculum->Record(episode, 1);

  EXPECT_THAT(RecentPassages(*curriculum), ElementsAre(1, 1, 1, 0));
  EXPECT_THAT(RecentFailures(*curriculum), ElementsAre(0, 0.3, 1, 0));
  EXPECT_EQ(curriculum->table().bins(2).failures(), 0);
}

TEST(Curriculum, PassesOverEpisodesThatDoNotBeginOnTheReference) {
  auto curriculum = MakeAdaptive(MakeLibrary());
  curriculum->Record(MakeEpisode(0, 2, 20, true), 1);
  curriculum->Reweigh();
  const std::string before = curriculum->table().SerializeAsString();

  for (const auto kind : {v1::START_KIND_FALLEN, v1::START_KIND_FAR,
                          v1::START_KIND_CARRIED, v1::START_KIND_GET_UP}) {
    v1::EpisodeEnd episode = MakeEpisode(1, 0, 3, true);
    episode.set_start_kind(kind);
    curriculum->Record(episode, 2);
  }

  EXPECT_EQ(curriculum->table().SerializeAsString(), before);
  curriculum->Reweigh();
  EXPECT_EQ(curriculum->table().SerializeAsString(), before);
}

TEST(Curriculum, PassesOverEvaluationsOfFallenStates) {
  auto curriculum = MakeAdaptive(MakeLibrary());
  v1::EvaluationResult fallen = MakeResult(0, 0, 20, 3);
  fallen.set_fallen_state(2);

  curriculum->RecordEvaluation({fallen, MakeResult(1, 0, 10, -1)}, 6);

  EXPECT_EQ(curriculum->table().clips(0).evaluations(), 0);
  EXPECT_EQ(curriculum->table().clips(0).last_evaluated(), -1);
  EXPECT_EQ(curriculum->table().clips(1).evaluations(), 1);
}

TEST(Curriculum, TakesTimesLongerThanAnyClip) {
  v1::Start start;
  start.set_rule(v1::Start::RULE_ADAPTIVE_BINS);
  start.set_bin_seconds(1e9);
  start.mutable_adaptive()->set_pre_failure_seconds(1e9);

  const auto curriculum = Curriculum::Create(start, MakeLibrary());
  ASSERT_THAT(curriculum, IsOk());
  (*curriculum)->Record(MakeEpisode(0, 5, 3, true), 1);
  (*curriculum)->Reweigh();

  ASSERT_EQ((*curriculum)->table().bins_size(), 2);
  EXPECT_EQ((*curriculum)->table().bins(0).num_frames(), 25);
  EXPECT_EQ((*curriculum)->table().bins(0).failures(), 1);
  EXPECT_EQ((*curriculum)->table().bins(1).num_frames(), 10);
}

TEST(Curriculum, ForgetsByHalfOverTheHalfLife) {
  auto curriculum = MakeAdaptive(MakeLibrary());
  // 40 passages over 4 bins are 10 of an average one.
  for (int i = 0; i < 40; ++i) {
    curriculum->Record(MakeEpisode(1, 0, 3, true), i);
  }

  curriculum->Reweigh();
  EXPECT_DOUBLE_EQ(curriculum->table().bins(3).recent_passages(), 20);
  EXPECT_DOUBLE_EQ(curriculum->table().bins(3).recent_failures(), 20);

  curriculum->Reweigh();  // nothing was seen since
  EXPECT_DOUBLE_EQ(curriculum->table().bins(3).recent_passages(), 20);
  EXPECT_EQ(curriculum->table().bins(3).visits(), 40);
}

TEST(Curriculum, TakesEvaluationsIn) {
  auto curriculum = MakeAdaptive(MakeLibrary());

  curriculum->RecordEvaluation(
      {MakeResult(0, 0, 20, -1), MakeResult(0, 12, 20, 3),
       MakeResult(1, 0, 10, -1)},
      /*iteration=*/6);

  const v1::CurriculumTable& table = curriculum->table();
  EXPECT_EQ(table.clips(0).name(), "loop");
  EXPECT_EQ(table.clips(0).evaluations(), 1);
  EXPECT_EQ(table.clips(0).failed_evaluations(), 1);
  EXPECT_TRUE(table.clips(0).failed_latest());
  EXPECT_EQ(table.clips(0).succeeded_share(), 0.5);
  EXPECT_DOUBLE_EQ(table.clips(0).mean_error_mm(), 30);
  EXPECT_EQ(table.clips(0).last_evaluated(), 6);
  EXPECT_FALSE(table.clips(1).failed_latest());
  EXPECT_EQ(table.clips(1).failed_evaluations(), 0);
  EXPECT_EQ(table.bins(0).visits(), 0);  // no episode
  // Nor do they dilute what episodes find.
  EXPECT_THAT(RecentPassages(*curriculum), Each(0));
  EXPECT_THAT(RecentFailures(*curriculum), Each(0));

  curriculum->RecordEvaluation({MakeResult(0, 0, 20, -1)}, 8);
  EXPECT_EQ(table.clips(0).evaluations(), 2);
  EXPECT_EQ(table.clips(0).failed_evaluations(), 1);
  EXPECT_FALSE(table.clips(0).failed_latest());
  EXPECT_EQ(table.clips(1).evaluations(), 1);
}

TEST(Curriculum, HasNoBinsForAClipThatIsLeftOut) {
  v1::MotionLibrary library = MakeLibrary();
  library.mutable_clips(0)->set_left_out(true);
  auto curriculum = MakeAdaptive(library);

  curriculum->RecordEvaluation({MakeResult(0, 0, 20, 3)}, 1);
  curriculum->Record(MakeEpisode(0, 0, 3, true), 1);
  curriculum->Record(MakeEpisode(1, 0, 3, true), 1);
  curriculum->Reweigh();

  const v1::CurriculumTable& table = curriculum->table();
  ASSERT_EQ(table.bins_size(), 1);
  EXPECT_EQ(table.bins(0).clip(), 1);
  EXPECT_EQ(table.bins(0).visits(), 1);
  EXPECT_DOUBLE_EQ(table.bins(0).probability(), 1);
  EXPECT_TRUE(table.clips(0).left_out());
  EXPECT_EQ(table.clips(0).failed_evaluations(), 1);
}

TEST(Curriculum, RefusesALibraryWithNothingToTrainOn) {
  v1::MotionLibrary library = MakeLibrary();
  for (auto& clip : *library.mutable_clips()) clip.set_left_out(true);

  EXPECT_THAT(Curriculum::Create(v1::Start(), library),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("not left out of training, found none in 2")));
  EXPECT_THAT(Curriculum::Create(v1::Start(), MakeLibrary(), {"one"}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("a digest for each of 2 clips, found 1")));
}

TEST(Curriculum, RefusesAClipWithoutAStep) {
  v1::MotionLibrary library = MakeLibrary();
  library.mutable_clips(1)->set_num_frames(1);
  library.mutable_clips(1)->set_loops(false);

  EXPECT_THAT(Curriculum::Create(v1::Start(), library),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("expected >= 2 frames, found 1")));
}

TEST(Curriculum, RefusesALibraryWithoutClips) {
  EXPECT_THAT(Curriculum::Create(v1::Start(), v1::MotionLibrary()),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("at least one clip")));
}

}  // namespace
}  // namespace sinew::learner
