// The single primitive beside a procedure: when it comes, what it costs.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>

#include "learner/procedure/procedure.h"
#include "learner/procedure/testing/procedure_history.h"

namespace sinew::learner {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// A single primitive beside what has ended with a composer, or is to.
History WithComparison() {
  History history;
  history.procedure.set_compare_single(true);
  history.procedure.set_negligible_clips(1);
  return history;
}

TEST(NextStage, TrainsASinglePrimitiveOnForComparisonAfterAllOthers) {
  History history = WithComparison();
  history.Finish({"b"});
  EXPECT_EQ(history.Next().next->kind, StageKind::kRecovery);
  history.Finish({"a", "b"});
  EXPECT_EQ(history.Next().next->kind, StageKind::kComposer);
  history.Finish({"c"});

  const Decision decision = history.Next();

  EXPECT_EQ(decision.next, (Stage{.kind = StageKind::kSingle,
                                  .primitive = 0,
                                  .from = 0,
                                  .clips = {},
                                  .primitives = {},
                                  .samples = 1280}));  // 2 * 640
  EXPECT_EQ(StageName(*decision.next), "single");
  EXPECT_EQ(decision.reason,
            "composer ended at its plateau after 640 samples and fails 1 of 4 "
            "clips; its policy is that of composer, which fails 1 clips; next "
            "primitive_0 by itself, on all clips, for as many samples as all "
            "stages after it took, 1280");
  EXPECT_THAT(decision.evidence.hard, ElementsAre("b"));
}

TEST(NextStage, EndsAfterTheSinglePrimitiveAndNeverComesToIt) {
  History history = WithComparison();
  history.Finish({"b"});
  history.Finish({"a", "b"});
  history.Finish({"c"});
  history.Finish({}, /*plateau=*/false);  // fails fewer than all others
  history.finished.back().samples = 1280;

  const Decision decision = history.Next();

  EXPECT_EQ(decision.next, std::nullopt);
  EXPECT_EQ(decision.reason,
            "single ended with its budget after 1280 samples and fails 0 of 4 "
            "clips, with 1920 samples in all beside the procedure's 1920; the "
            "procedure is over, its policy is that of composer, which fails 1 "
            "clips");
  EXPECT_EQ(ResultStage(history.finished), 2);
}

TEST(NextStage, TrainsASinglePrimitiveOnAfterStagesThatTrackAlone) {
  History history = WithComparison();
  history.procedure.set_max_primitives(1);
  history.procedure.set_recovery_samples(0);
  history.procedure.set_composer_samples(0);
  history.Finish({"b", "c"});
  EXPECT_EQ(history.Next().next->kind, StageKind::kHard);
  history.Finish({"c"});

  const Decision decision = history.Next();

  ASSERT_TRUE(decision.next.has_value());
  EXPECT_EQ(decision.next->kind, StageKind::kSingle);
  EXPECT_EQ(decision.next->from, 0);
  EXPECT_EQ(decision.next->samples, 640);
  EXPECT_THAT(decision.reason,
              HasSubstr("no composer; its policy is that of primitive_0_hard"));
}

TEST(NextStage, ComparesNothingWithOneStageAlone) {
  History history = WithComparison();
  history.procedure.set_recovery_samples(0);
  history.Finish({});

  const Decision decision = history.Next();

  EXPECT_EQ(decision.next, std::nullopt);
  EXPECT_THAT(decision.reason,
              AllOf(HasSubstr("the procedure is over"),
                    HasSubstr("; one stage alone: nothing to compare")));
}

TEST(Compare, CountsTheSamplesOfBothSides) {
  History history = WithComparison();
  history.Finish({"b"});
  history.Finish({"a", "b"});
  history.Finish({"c", "d"});
  EXPECT_FALSE(Compare(history.finished).has_value());
  EXPECT_FALSE(Compare({}).has_value());
  history.Finish({"a", "c", "d"});
  history.finished.back().samples = 1300;  // rounded up to iterations

  const auto both = Compare(history.finished);

  ASSERT_TRUE(both.has_value());
  EXPECT_EQ(both->procedure.stage, 2);       // which recovers
  EXPECT_EQ(both->procedure.samples, 1920);  // 3 * 640
  EXPECT_EQ(both->procedure.failed, 2);
  EXPECT_EQ(both->single.stage, 3);
  EXPECT_EQ(both->single.samples, 1940);  // 640 + 1300
  EXPECT_EQ(both->single.failed, 3);
}

TEST(CostOf, LeavesTheSinglePrimitiveOut) {
  History history = WithComparison();
  for (int i = 0; i < 4; ++i) history.Finish({"b"});
  ASSERT_EQ(history.finished.back().stage.kind, StageKind::kSingle);

  EXPECT_EQ(CostOf(history.finished).samples, 1920);
  EXPECT_EQ(CostOf(history.finished).train_seconds, 3);
  EXPECT_EQ(CostOf({}).samples, 0);
}

}  // namespace
}  // namespace sinew::learner
