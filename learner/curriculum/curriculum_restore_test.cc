// Tables of before: of the same library, and of another one.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "common/random/philox.h"
#include "common/testing/matchers.h"
#include "learner/curriculum/curriculum.h"
#include "learner/curriculum/testing/curriculum_rig.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

TEST(Curriculum, RestoresATableAndRefusesOneOfOtherBins) {
  auto curriculum = MakeCurriculum(v1::Start::RULE_BINS);
  curriculum->Record(MakeEpisode(1, 0, 3, true), 1);
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

// Some random episodes and, at times, an evaluation.
void RunIteration(Curriculum& curriculum, uint64_t iteration) {
  const RandomKey key{.seed = 5, .environment = iteration};
  for (uint64_t e = 0; e < 8; ++e) {
    const int clip = static_cast<int>(UniformInt(key, 2, 4 * e));
    const auto start = static_cast<int>(UniformInt(key, 10, 4 * e + 1));
    const auto steps = static_cast<int>(1 + UniformInt(key, 80, 4 * e + 2));
    curriculum.Record(
        MakeEpisode(clip, start, clip == 0 ? steps : 1 + steps % (10 - start),
                    Uniform(key, 4 * e + 3) < 0.5),
        static_cast<int64_t>(iteration));
  }
  if (iteration % 5 == 0) {
    const auto failed_at = static_cast<int>(iteration % 3) - 1;
    curriculum.RecordEvaluation(
        {MakeResult(0, 0, 60, failed_at > 0 ? failed_at : -1),
         MakeResult(1, 0, 10, -1)},
        static_cast<int64_t>(iteration));
  }
  curriculum.Reweigh();
}

TEST(Curriculum, GoesOnBitForBitWhereItWasRestored) {
  auto whole = MakeAdaptive(MakeLibrary());
  for (uint64_t k = 0; k < 20; ++k) RunIteration(*whole, k);
  auto resumed = MakeAdaptive(MakeLibrary());
  ASSERT_THAT(resumed->Restore(whole->table()), IsOk());

  for (uint64_t k = 20; k < 40; ++k) {
    RunIteration(*whole, k);
    RunIteration(*resumed, k);
  }

  EXPECT_EQ(resumed->table().SerializeAsString(),
            whole->table().SerializeAsString());
  for (const auto& bin : whole->table().bins()) {
    EXPECT_GT(bin.recent_passages(), 0);
    EXPECT_GE(bin.recent_failures(), 0);
    EXPECT_LE(bin.recent_failures(), bin.recent_passages());
  }
  EXPECT_NEAR(TotalProbability(whole->table()), 1, 1e-12);
}

TEST(Curriculum, RestoresATableFromBeforeClipsWereRemembered) {
  auto curriculum = MakeAdaptive(MakeLibrary());
  curriculum->Record(MakeEpisode(1, 0, 3, true), 1);
  v1::CurriculumTable old = curriculum->table();
  old.clear_clips();
  auto other = MakeAdaptive(MakeLibrary());

  ASSERT_THAT(other->Restore(old), IsOk());

  EXPECT_EQ(other->table().bins(3).visits(), 1);
  EXPECT_EQ(other->table().clips_size(), 2);
}

TEST(Curriculum, RefusesATableOfOtherClips) {
  auto curriculum = MakeAdaptive(MakeLibrary());
  v1::CurriculumTable table = curriculum->table();
  table.mutable_clips(1)->set_name("twice");
  v1::CurriculumTable shorter = curriculum->table();
  shorter.mutable_clips()->RemoveLast();

  EXPECT_THAT(curriculum->Restore(table),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("clip 1: expected once, found twice")));
  EXPECT_THAT(curriculum->Restore(shorter),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("expected 2 clips, found 1")));
}

// Another library: "once", changed; "new"; "loop", as it was.
v1::MotionLibrary MakeOtherLibrary() {
  v1::MotionLibrary library;
  library.set_frames_per_second(10);
  *library.add_clips() = MakeLibrary().clips(1);
  auto& added = *library.add_clips();
  added.set_name("new");
  added.set_num_frames(11);
  *library.add_clips() = MakeLibrary().clips(0);
  return library;
}

TEST(Curriculum, AdoptsTheStatisticsOfUnchangedClips) {
  auto before = MakeAdaptive(MakeLibrary(), {"a", "b"});
  before->Record(MakeEpisode(0, 2, 20, true), 3);
  before->Record(MakeEpisode(1, 0, 3, true), 4);
  before->RecordEvaluation({MakeResult(0, 0, 20, 3)}, 5);
  before->Reweigh();
  auto after = MakeAdaptive(MakeOtherLibrary(), {"changed", "c", "a"});

  EXPECT_EQ(after->Adopt(before->table()), 1);

  const v1::CurriculumTable& table = after->table();
  ASSERT_EQ(table.bins_size(), 5);  // once, new, loop, loop, loop
  EXPECT_EQ(table.bins(0).visits(), 0);
  EXPECT_EQ(table.bins(1).visits(), 0);
  EXPECT_EQ(table.bins(2).visits(), 1);
  EXPECT_EQ(table.bins(2).clip(), 2);
  EXPECT_EQ(table.bins(4).failures(), 1);
  EXPECT_EQ(table.bins(4).recent_failures(),
            before->table().bins(2).recent_failures());
  EXPECT_EQ(table.clips(2).failed_evaluations(), 1);
  EXPECT_EQ(table.clips(0).evaluations(), 0);
  EXPECT_NEAR(TotalProbability(table), 1, 1e-12);
}

TEST(Curriculum, AdoptsEvaluationsOfAClipThatIsNowLeftOut) {
  auto before = MakeAdaptive(MakeLibrary(), {"a", "b"});
  before->RecordEvaluation({MakeResult(0, 0, 20, 3)}, 5);
  v1::MotionLibrary library = MakeLibrary();
  library.mutable_clips(0)->set_left_out(true);
  auto after = MakeAdaptive(library, {"a", "b"});
  auto again = MakeAdaptive(MakeLibrary(), {"a", "b"});

  EXPECT_EQ(after->Adopt(before->table()), 2);
  EXPECT_EQ(again->Adopt(after->table()), 2);

  EXPECT_TRUE(after->table().clips(0).left_out());
  EXPECT_EQ(after->table().clips(0).failed_evaluations(), 1);
  EXPECT_FALSE(again->table().clips(0).left_out());
  EXPECT_EQ(again->table().bins(0).visits(), 0);
}

TEST(Curriculum, AdoptsNothingWithoutDigests) {
  auto before = MakeAdaptive(MakeLibrary());
  auto after = MakeAdaptive(MakeLibrary());

  EXPECT_EQ(after->Adopt(before->table()), 0);
  EXPECT_EQ(after->Adopt(v1::CurriculumTable()), 0);
}

}  // namespace
}  // namespace sinew::learner
