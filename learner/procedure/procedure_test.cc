#include "learner/procedure/procedure.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "learner/procedure/testing/procedure_history.h"

namespace sinew::learner {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(NextStage, BeginsWithTheFirstPrimitiveOnAllClips) {
  const Decision decision = History().Next();

  EXPECT_EQ(decision.next, Stage());
  EXPECT_EQ(StageName(*decision.next), "primitive_0");
  EXPECT_EQ(decision.reason, "primitive_0 begins on all 4 clips");
}

TEST(NextStage, GoesOnWithTheSamePrimitiveOnWhatItFails) {
  History history;
  history.Finish({"b", "d"});

  const Decision decision = history.Next();

  EXPECT_EQ(decision.next, (Stage{.kind = StageKind::kHard,
                                  .primitive = 0,
                                  .from = 0,
                                  .clips = {"b", "d"},
                                  .primitives = {}}));
  EXPECT_EQ(StageName(*decision.next), "primitive_0_hard");
  EXPECT_EQ(decision.reason,
            "primitive_0 ended at its plateau after 640 samples; no primitive "
            "wins 2 of 4 clips (b, d): primitive_0 goes on on them");
  EXPECT_THAT(decision.evidence.hard, ElementsAre("b", "d"));
  EXPECT_EQ(decision.evidence.clips, 4);
}

TEST(NextStage, SaysThatAStageEndedWithItsBudget) {
  History history;
  history.Finish({"b"}, /*plateau=*/false);

  EXPECT_THAT(history.Next().reason,
              HasSubstr("primitive_0 ended with its budget after 640 samples"));
}

TEST(NextStage, LeavesTrackingOnceNothingFails) {
  History history;
  history.Finish({});

  const Decision decision = history.Next();

  EXPECT_EQ(decision.next, (Stage{.kind = StageKind::kRecovery,
                                  .primitive = 1,
                                  .from = 0,
                                  .clips = {},
                                  .primitives = {}}));
  EXPECT_THAT(decision.reason,
              AllOf(HasSubstr("no primitive wins 0 of 4 clips, at most "
                              "negligible_clips = 0: no more tracking"),
                    HasSubstr("recovers, from primitive_0")));
}

TEST(NextStage, TakesANegligibleHardSetForEmpty) {
  History history;
  history.procedure.set_negligible_clips(2);
  history.Finish({"b", "d"});

  const Decision decision = history.Next();

  EXPECT_EQ(decision.next->kind, StageKind::kRecovery);
  EXPECT_THAT(decision.reason, HasSubstr("at most negligible_clips = 2"));
}

TEST(NextStage, GrowsAPrimitiveOnWhatTheFirstDoesNotLearn) {
  History history;
  history.Finish({"b", "d"});
  history.Finish({"d"});  // won 1 of 2: the share that is asked for

  const Decision decision = history.Next();

  EXPECT_EQ(decision.next, (Stage{.kind = StageKind::kGrown,
                                  .primitive = 1,
                                  .from = 1,
                                  .clips = {"d"},
                                  .primitives = {}}));
  EXPECT_EQ(StageName(*decision.next), "primitive_1");
  EXPECT_EQ(decision.reason,
            "primitive_0_hard ended at its plateau after 640 samples and won 1 "
            "of its 2 hard clips; no primitive wins 1 of 4 clips (d): "
            "primitive_1 is grown from primitive_0");
}

TEST(NextStage, GrowsNothingForWhatCannotBeLearned) {
  History history;
  history.Finish({"b", "c", "d"});
  history.Finish({"b", "d"});  // won 1 of 3

  const Decision decision = history.Next();

  EXPECT_EQ(decision.next->kind, StageKind::kRecovery);
  EXPECT_THAT(decision.reason,
              AllOf(HasSubstr("(b, d)"),
                    HasSubstr("won 0.33 of its hard set, less than "
                              "learnable_share = 0.50: what is left cannot be "
                              "learned")));
  EXPECT_EQ(decision.evidence.hard_before, 3);
  EXPECT_EQ(decision.evidence.hard_won, 1);
}

TEST(NextStage, TakesTheLearnableShareItselfForEnough) {
  const Clips ten = {"a", "b", "c", "d", "e", "f", "g", "h", "i", "j"};
  v1::Procedure procedure = MakeProcedure();
  // As doubles, 3 * 0.1 * 10 is more than 3.
  for (const int won : {1, 3, 6, 7, 9}) {
    procedure.set_learnable_share(won * 0.1);
    const FinishedStage full = {.stage = {}, .failed = ten};
    const FinishedStage hard = {.stage = {.kind = StageKind::kHard,
                                          .primitive = 0,
                                          .from = 0,
                                          .clips = ten,
                                          .primitives = {}},
                                .failed = Clips(ten.begin() + won, ten.end())};

    const Decision decision = NextStage(procedure, ten, {{full, hard}});

    ASSERT_TRUE(decision.next.has_value());
    EXPECT_EQ(decision.next->kind, StageKind::kGrown) << decision.reason;
  }
}

TEST(NextStage, AGrownPrimitiveGoesOnOnWhatNobodyWins) {
  History history;
  history.Finish({"a", "b", "c"});
  history.Finish({"b", "c"});
  history.procedure.set_learnable_share(0.1);
  // The grown one loses "a" and "d", which primitive 0 wins.
  history.Finish({"a", "c", "d"});

  const Decision decision = history.Next();

  EXPECT_EQ(decision.next, (Stage{.kind = StageKind::kHard,
                                  .primitive = 1,
                                  .from = 2,
                                  .clips = {"c"},
                                  .primitives = {}}));
  EXPECT_EQ(StageName(*decision.next), "primitive_1_hard");
  EXPECT_EQ(decision.evidence.forgotten, 0);
}

TEST(NextStage, CountsWhatAPrimitiveForgotOnItsHardSet) {
  History history;
  history.Finish({"c", "d"});
  history.Finish({"a", "d"});

  const Decision decision = history.Next();

  EXPECT_THAT(decision.next->clips, ElementsAre("a", "d"));
  EXPECT_EQ(decision.evidence.forgotten, 1);
  EXPECT_THAT(decision.reason, HasSubstr("(a, d), 1 of which were won before"));
}

TEST(NextStage, GrowsNoMorePrimitivesThanItMay) {
  History history;
  history.procedure.set_learnable_share(0);
  history.Finish({"c", "d"});
  history.Finish({"c", "d"});
  history.Finish({"c", "d"});
  history.Finish({"c", "d"});  // primitive_1_hard

  const Decision decision = history.Next();

  EXPECT_EQ(decision.next->kind, StageKind::kRecovery);
  EXPECT_EQ(decision.next->primitive, 2);
  EXPECT_EQ(decision.next->from, 3);
  EXPECT_THAT(decision.reason, HasSubstr("max_primitives = 2 is reached"));
}

TEST(NextStage, ComposesTheLatestStageOfEachPrimitive) {
  History history;
  history.Finish({"c", "d"});
  history.Finish({"d"});
  history.Finish({"a", "b", "c"});
  history.Finish({"a", "c"});  // recovery

  const Decision decision = history.Next();

  EXPECT_EQ(decision.next, (Stage{.kind = StageKind::kComposer,
                                  .primitive = 3,
                                  .from = -1,
                                  .clips = {},
                                  .primitives = {1, 2, 3}}));
  EXPECT_THAT(
      decision.reason,
      HasSubstr("recovery ended at its plateau after 640 samples and fails 2 "
                "of 4 clips; next a composer over 3 primitives"));
}

TEST(NextStage, ComposesWithoutRecoveryIfNoneIsAskedFor) {
  History history;
  history.procedure.set_recovery_samples(0);
  history.Finish({"d"});
  history.Finish({"d", "a"});
  EXPECT_EQ(history.Next().next, std::nullopt);  // one primitive alone
  EXPECT_THAT(history.Next().reason,
              HasSubstr("one primitive alone: no composer"));
  history.procedure.set_learnable_share(0);
  history.Finish({"a", "b", "c"});

  const Decision decision = history.Next();

  EXPECT_EQ(decision.next->kind, StageKind::kHard);  // "a" is nobody's still
  history.Finish({"b", "c"});
  EXPECT_THAT(history.Next().next->primitives, ElementsAre(1, 3));
}

TEST(NextStage, EndsAfterTheComposer) {
  History history;
  history.procedure.set_negligible_clips(1);
  history.Finish({"b"});
  history.Finish({"a", "b"});
  history.Finish({"c"});

  const Decision decision = history.Next();

  EXPECT_EQ(decision.next, std::nullopt);
  EXPECT_THAT(decision.reason,
              HasSubstr("the procedure is over, its policy is that of "
                        "composer, which fails 1 clips"));
  EXPECT_EQ(ResultStage(history.finished), 2);
}

TEST(NextStage, PrefersAPrimitiveToAComposerThatFailsMore) {
  History history;
  history.procedure.set_recovery_samples(0);
  history.procedure.set_learnable_share(0);
  history.Finish({"d"});
  history.Finish({"d"});
  history.Finish({"a"});
  ASSERT_EQ(history.Next().next->kind, StageKind::kComposer);
  history.Finish({"a", "b"});

  EXPECT_THAT(history.Next().reason,
              HasSubstr("its policy is that of primitive_1, which fails 1"));
  EXPECT_EQ(ResultStage(history.finished), 2);
}

TEST(NextStage, PrefersWhatRecoversToAPrimitiveThatFailsLess) {
  History history;
  history.Finish({});
  history.Finish({"a"});
  EXPECT_EQ(ResultStage(history.finished), 1);
  history.Finish({"a", "c"});

  EXPECT_THAT(history.Next().reason,
              HasSubstr("its policy is that of recovery, which fails 1"));
  EXPECT_EQ(ResultStage(history.finished), 1);
}

TEST(NextStage, EndsWithoutAComposerIfNoneIsAskedFor) {
  History history;
  history.procedure.set_composer_samples(0);
  history.Finish({"c"});
  history.Finish({"c", "b"});
  EXPECT_EQ(history.Next().next->kind, StageKind::kRecovery);
  history.Finish({"a", "b"});

  const Decision decision = history.Next();

  EXPECT_EQ(decision.next, std::nullopt);
  EXPECT_THAT(decision.reason, AllOf(HasSubstr("composer_samples = 0"),
                                     HasSubstr("that of recovery, ")));
}

TEST(NextStage, NamesTwentyClipsAndCountsTheOthers) {
  Clips many;
  for (int i = 0; i < 23; ++i) many.push_back("clip" + std::to_string(i));
  const FinishedStage first = {.stage = {}, .failed = many};

  const Decision decision = NextStage(MakeProcedure(), many, {{first}});

  EXPECT_THAT(decision.reason, HasSubstr("clip19 and 3 more)"));
  EXPECT_EQ(decision.evidence.hard, many);
}

TEST(ResultStage, IsTheLatestOfThoseThatFailTheFewest) {
  std::vector<FinishedStage> finished(3);
  finished[0].failed = {"a", "b"};
  finished[1].failed = {"c"};
  finished[2].failed = {"d"};

  EXPECT_EQ(ResultStage(finished), 2);
}

TEST(StageKind, IsReadBackFromItsName) {
  for (const StageKind kind :
       {StageKind::kFull, StageKind::kHard, StageKind::kGrown,
        StageKind::kRecovery, StageKind::kComposer, StageKind::kSingle}) {
    EXPECT_EQ(KindOfName(KindName(kind)), kind);
  }
  EXPECT_EQ(KindOfName("other"), std::nullopt);
}

}  // namespace
}  // namespace sinew::learner
