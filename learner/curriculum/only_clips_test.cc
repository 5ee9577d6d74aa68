// A curriculum whose starts are drawn from some clips alone.

#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "learner/curriculum/curriculum.h"
#include "learner/curriculum/curriculum_summary.h"
#include "learner/curriculum/testing/curriculum_rig.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::EqualsProto;
using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;

constexpr int kOnce = 1;

// "loop" (3 bins), "once" (1 bin) unless it is not wanted, "long" (4 bins), and
// "out", which is left out.
v1::MotionLibrary MakeFourClips(bool with_once = true) {
  v1::MotionLibrary library;
  library.set_frames_per_second(10);
  *library.add_clips() = MakeLibrary().clips(0);
  if (with_once) *library.add_clips() = MakeLibrary().clips(kOnce);
  auto& longer = *library.add_clips();
  longer.set_name("long");
  longer.set_num_frames(41);
  auto& out = *library.add_clips();
  out.set_name("out");
  out.set_num_frames(20);
  out.set_left_out(true);
  return library;
}

v1::Start MakeStart(v1::Start::Rule rule,
                    const std::vector<std::string>& only = {}) {
  v1::Start start;
  start.set_rule(rule);
  start.set_bin_seconds(1);
  start.set_uniform_share(0.1);
  start.mutable_only_clips()->Assign(only.begin(), only.end());
  return start;
}

std::unique_ptr<Curriculum> Make(const v1::Start& start,
                                 const v1::MotionLibrary& library,
                                 const std::vector<std::string>& sha256 = {}) {
  auto curriculum = Curriculum::Create(start, library, sha256);
  EXPECT_THAT(curriculum, IsOk());
  return *std::move(curriculum);
}

// Iterations and an evaluation of "loop" and "long", whose index is given.
void Train(int longer, bool with_once, Curriculum& curriculum) {
  for (int i = 0; i < 5; ++i) {
    curriculum.Record(MakeEpisode(0, 3, 12, true), i);
    curriculum.Record(MakeEpisode(0, 0, 20, false), i);
    curriculum.Record(MakeEpisode(longer, 5, 30, i % 2 == 0), i);
    if (i == 2) {
      std::vector<v1::EvaluationResult> results = {
          MakeResult(0, 0, 25, -1), MakeResult(longer, 0, 40, 12)};
      if (with_once) results.push_back(MakeResult(kOnce, 0, 10, 3));
      curriculum.RecordEvaluation(results, 1);
    }
    curriculum.Reweigh();
  }
}

class OnlyClips : public ::testing::TestWithParam<v1::Start::Rule> {};

TEST_P(OnlyClips, AreWeighedLikeALibraryOfTheseClips) {
  const auto all =
      Make(MakeStart(GetParam(), {"long", "loop"}), MakeFourClips());
  const auto part = Make(MakeStart(GetParam()), MakeFourClips(false));
  Train(/*longer=*/2, /*with_once=*/true, *all);
  Train(/*longer=*/1, /*with_once=*/false, *part);

  ASSERT_EQ(all->table().bins_size(), 8);
  ASSERT_EQ(part->table().bins_size(), 7);
  int next = 0;
  for (const auto& bin : all->table().bins()) {
    if (bin.clip() == kOnce) {
      EXPECT_EQ(bin.probability(), 0);
      continue;
    }
    const v1::CurriculumTable::Bin& expected = part->table().bins(next++);
    EXPECT_DOUBLE_EQ(bin.probability(), expected.probability());
    EXPECT_EQ(bin.recent_passages(), expected.recent_passages());
  }
  EXPECT_NEAR(TotalProbability(all->table()), 1, 1e-12);
  // Evaluations count for all clips.
  EXPECT_EQ(all->table().clips(kOnce).failed_evaluations(), 1);
}

TEST_P(OnlyClips, AreSummarisedLikeALibraryOfTheseClips) {
  const auto all =
      Make(MakeStart(GetParam(), {"loop", "long"}), MakeFourClips());
  const auto part = Make(MakeStart(GetParam()), MakeFourClips(false));
  Train(2, true, *all);
  Train(1, false, *part);

  const CurriculumSummary found = Summarise(all->table(), all->rule());
  const CurriculumSummary expected = Summarise(part->table(), part->rule());

  EXPECT_EQ(found.clips, 3);
  EXPECT_EQ(found.drawn_clips, 2);
  EXPECT_EQ(found.left_out_clips, 1);
  EXPECT_EQ(expected.drawn_clips, 2);
  EXPECT_EQ(found.bins, 7);
  EXPECT_DOUBLE_EQ(found.entropy, expected.entropy);
  EXPECT_DOUBLE_EQ(found.entropy_share, expected.entropy_share);
  EXPECT_DOUBLE_EQ(found.floor_share, expected.floor_share);
  EXPECT_DOUBLE_EQ(found.largest_clip_share, expected.largest_clip_share);
  EXPECT_EQ(found.clips_of_half, expected.clips_of_half);
  EXPECT_DOUBLE_EQ(found.failure_rate, expected.failure_rate);
  EXPECT_DOUBLE_EQ(found.hardest_share, expected.hardest_share);
  EXPECT_EQ(found.evaluated_clips, 3);
  EXPECT_EQ(found.hard_clips, 2);
}

// As a library of the named clips and one of the others, side by side.
TEST_P(OnlyClips, LeaveAShareToTheOthers) {
  v1::Start start = MakeStart(GetParam(), {"long", "loop"});
  start.set_other_clips_share(0.25);
  const auto all = Make(start, MakeFourClips());
  const auto named =
      Make(MakeStart(GetParam(), {"long", "loop"}), MakeFourClips());
  const auto others = Make(MakeStart(GetParam(), {"once"}), MakeFourClips());
  for (Curriculum* curriculum : {all.get(), named.get(), others.get()}) {
    Train(2, true, *curriculum);
  }

  // What adaptive bins remember lasts for so many passages of a bin that is
  // drawn from, and here more of them are.
  const double tolerance =
      GetParam() == v1::Start::RULE_ADAPTIVE_BINS ? 1e-3 : 1e-12;
  for (int i = 0; i < all->table().bins_size(); ++i) {
    EXPECT_NEAR(all->table().bins(i).probability(),
                0.75 * named->table().bins(i).probability() +
                    0.25 * others->table().bins(i).probability(),
                tolerance);
  }
  EXPECT_NEAR(TotalProbability(all->table()), 1, 1e-12);
  const CurriculumSummary found = Summarise(all->table(), all->rule());
  EXPECT_EQ(found.drawn_clips, 3);
  EXPECT_DOUBLE_EQ(
      found.floor_share,
      0.75 * Summarise(named->table(), named->rule()).floor_share +
          0.25 * Summarise(others->table(), others->rule()).floor_share);
  EXPECT_TRUE(all->Draws(kOnce));
}

INSTANTIATE_TEST_SUITE_P(Rules, OnlyClips,
                         ::testing::Values(v1::Start::RULE_UNIFORM,
                                           v1::Start::RULE_BINS,
                                           v1::Start::RULE_PHC_SOFT,
                                           v1::Start::RULE_PHC_HARD,
                                           v1::Start::RULE_ADAPTIVE_BINS));

TEST(OnlyClipsOfACurriculum, AreThoseThatItDrawsFrom) {
  const auto all = Make(MakeStart(v1::Start::RULE_UNIFORM), MakeFourClips());
  const auto some =
      Make(MakeStart(v1::Start::RULE_UNIFORM, {"long"}), MakeFourClips());

  const std::vector<bool> drawn_of_all = {true, true, true, false};
  for (int clip = 0; clip < 4; ++clip) {
    EXPECT_EQ(all->Draws(clip), drawn_of_all[clip]) << clip;
    EXPECT_EQ(some->Draws(clip), clip == 2) << clip;
  }
}

TEST(OnlyClipsOfACurriculum, KeepTheirShareIfThereAreNoOthers) {
  v1::Start start = MakeStart(v1::Start::RULE_ADAPTIVE_BINS, {"long", "loop"});
  start.set_other_clips_share(0.25);
  const auto all = Make(start, MakeFourClips(/*with_once=*/false));

  EXPECT_NEAR(TotalProbability(all->table()), 1, 1e-12);
}

TEST(OnlyClipsOfACurriculum, AreTheOnlyOnesAmongTheHardest) {
  const auto some =
      Make(MakeStart(v1::Start::RULE_ADAPTIVE_BINS, {"loop"}), MakeFourClips());

  const v1::CurriculumTable drawn = DrawnPart(some->table(), some->rule());

  EXPECT_THAT(HardestClips(drawn, 10), ::testing::ElementsAre(0));
  EXPECT_EQ(HardestBins(drawn, 10).size(), 3u);
}

// What was known of a clip stays until starts are drawn from it again.
TEST(OnlyClipsOfACurriculum, LeaveTheStatisticsOfTheOthersAlone) {
  const std::vector<std::string> sha256 = {"a", "b", "c", "d"};
  const auto before =
      Make(MakeStart(v1::Start::RULE_ADAPTIVE_BINS), MakeFourClips(), sha256);
  before->Record(MakeEpisode(kOnce, 0, 4, true), 0);
  before->Reweigh();
  const auto after = Make(MakeStart(v1::Start::RULE_ADAPTIVE_BINS, {"long"}),
                          MakeFourClips(), sha256);
  EXPECT_EQ(after->Adopt(before->table()), 4);

  for (int i = 1; i < 4; ++i) {
    after->Record(MakeEpisode(2, 0, 30, true), i);
    after->Reweigh();
  }

  const v1::CurriculumTable::Bin& old = before->table().bins(3);
  const v1::CurriculumTable::Bin& kept = after->table().bins(3);
  ASSERT_EQ(old.clip(), kOnce);
  EXPECT_GT(old.recent_failures(), 0);
  EXPECT_EQ(kept.visits(), 1);
  EXPECT_EQ(kept.recent_passages(), old.recent_passages());
  EXPECT_EQ(kept.recent_failures(), old.recent_failures());
  EXPECT_EQ(kept.probability(), 0);
}

TEST(OnlyClipsOfACurriculum, AreRestoredBitForBit) {
  const v1::Start start = MakeStart(v1::Start::RULE_ADAPTIVE_BINS, {"loop"});
  const auto first = Make(start, MakeFourClips());
  first->Record(MakeEpisode(0, 3, 12, true), 0);
  first->Reweigh();
  const auto second = Make(start, MakeFourClips());

  ASSERT_THAT(second->Restore(first->table()), IsOk());
  for (Curriculum* curriculum : {first.get(), second.get()}) {
    curriculum->Record(MakeEpisode(0, 0, 8, false), 1);
    curriculum->Reweigh();
  }

  EXPECT_THAT(second->table(), EqualsProto(first->table()));
}

TEST(OnlyClipsOfACurriculum, MustBeClipsThatAreTrainedOn) {
  EXPECT_THAT(
      Curriculum::Create(MakeStart(v1::Start::RULE_UNIFORM, {"loop", "lonk"}),
                         MakeFourClips()),
      StatusIs(absl::StatusCode::kInvalidArgument,
               "recipe field task.start.only_clips: expected a clip of the "
               "library (the nearest is \"long\"), found \"lonk\""));
  EXPECT_THAT(
      Curriculum::Create(MakeStart(v1::Start::RULE_UNIFORM, {"out"}),
                         MakeFourClips()),
      StatusIs(absl::StatusCode::kInvalidArgument,
               "recipe field task.start.only_clips: expected a clip of the "
               "library that is not left out of training, found \"out\""));
}

}  // namespace
}  // namespace sinew::learner
