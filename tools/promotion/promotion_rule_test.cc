#include "tools/promotion/promotion_rule.h"

#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

constexpr PromotionRule kRule = {.success_tolerance = 0.01,
                                 .error_tolerance = 0.02};

struct Clip {
  bool success = true;
  double error_mm = 0;
  int frames = 100;  // reached, of 100
};

// The figures that follow from clips, as an evaluation has them.
EvaluationSummary Evaluated(const std::vector<Clip>& clips) {
  EvaluationSummary summary;
  SetSummary& set = summary.overall;
  for (const Clip& clip : clips) {
    ClipSummary& one = summary.clips.emplace_back();
    one.clip = set.clips++;
    one.success = clip.success;
    one.frames = clip.frames;
    one.means.e_g_mpjpe_mm = clip.error_mm;
    set.succeeded_clips += clip.success ? 1 : 0;
    set.frames += clip.frames;
    set.means.e_g_mpjpe_mm += clip.error_mm * clip.frames;
  }
  set.success_rate = static_cast<double>(set.succeeded_clips) / set.clips;
  set.survived_share = static_cast<double>(set.frames) / (100 * set.clips);
  if (set.frames > 0) {
    set.means.e_g_mpjpe_mm /= static_cast<double>(set.frames);
  }
  return summary;
}

// So many clips of 100 win, the first ones, all with one error.
EvaluationSummary Figures(int won, double error_mm) {
  std::vector<Clip> clips(100, {.success = true, .error_mm = error_mm});
  for (size_t i = static_cast<size_t>(won); i < clips.size(); ++i) {
    clips[i].success = false;
  }
  return Evaluated(clips);
}

TEST(Promotion, TakesWhatIsBetter) {
  EXPECT_TRUE(
      JudgePromotion(Figures(100, 30), Figures(90, 40), kRule).promoted);
}

TEST(Promotion, TakesWhatIsAsGood) {
  const EvaluationSummary same = Figures(97, 33);

  EXPECT_TRUE(JudgePromotion(same, same, kRule).promoted);
  EXPECT_TRUE(JudgePromotion(same, same, {0, 0}).promoted);
}

TEST(Promotion, ToleratesWhatTheRuleStatesAndNoMore) {
  const EvaluationSummary incumbent = Figures(95, 40);

  // 0.95 - 0.01 = 0.94; 40 * 1.02 = 40.8.
  EXPECT_TRUE(JudgePromotion(Figures(94, 40.8), incumbent, kRule).promoted);
  const PromotionVerdict fewer =
      JudgePromotion(Figures(93, 10), incumbent, kRule);
  const PromotionVerdict further =
      JudgePromotion(Figures(100, 40.9), incumbent, kRule);

  EXPECT_FALSE(fewer.promoted);
  EXPECT_EQ(fewer.reason,
            "success rate: expected at least 94.0 % (the incumbent's 95.0 less "
            "1.0), found 93.0 %");
  EXPECT_FALSE(further.promoted);
  EXPECT_EQ(further.reason,
            "E_g-mpjpe of clips that both win (95): expected at most 40.80 mm "
            "(the incumbent's 40.00 and 2.0 % more), found 40.90 mm");
}

TEST(Promotion, TakesWhatSurvivesLongerThoughItsErrorOverAllFramesGrows) {
  // The clip that the incumbent loses at once: the candidate wins it, far off.
  const EvaluationSummary incumbent =
      Evaluated({{.success = true, .error_mm = 40},
                 {.success = false, .error_mm = 40, .frames = 10}});
  const EvaluationSummary candidate = Evaluated(
      {{.success = true, .error_mm = 40}, {.success = true, .error_mm = 50}});
  ASSERT_EQ(candidate.overall.means.e_g_mpjpe_mm, 45);
  ASSERT_EQ(incumbent.overall.means.e_g_mpjpe_mm, 40);

  const PromotionVerdict verdict = JudgePromotion(candidate, incumbent, kRule);

  EXPECT_TRUE(verdict.promoted) << verdict.reason;
  EXPECT_EQ(verdict.common.clips, 1);
  EXPECT_EQ(verdict.common.candidate_mm, 40);
  EXPECT_EQ(verdict.common.incumbent_mm, 40);
}

TEST(Promotion, RefusesALargerErrorWhereBothWinWhateverElseIsWon) {
  const EvaluationSummary incumbent =
      Evaluated({{.success = true, .error_mm = 40, .frames = 100},
                 {.success = true, .error_mm = 60, .frames = 50},
                 {.success = false, .error_mm = 200, .frames = 90}});
  const EvaluationSummary candidate =
      Evaluated({{.success = true, .error_mm = 44, .frames = 100},
                 {.success = true, .error_mm = 60, .frames = 50},
                 {.success = true, .error_mm = 20, .frames = 100}});

  const PromotionVerdict verdict = JudgePromotion(candidate, incumbent, kRule);

  // (40 * 100 + 60 * 50) / 150 = 46.67, of which 102 % are 47.60;
  // (44 * 100 + 60 * 50) / 150 = 49.33.
  EXPECT_FALSE(verdict.promoted);
  EXPECT_EQ(verdict.reason,
            "E_g-mpjpe of clips that both win (2): expected at most 47.60 mm "
            "(the incumbent's 46.67 and 2.0 % more), found 49.33 mm");
}

TEST(Promotion, TakesMoreSuccessWhereNoClipIsWonByBoth) {
  const EvaluationSummary incumbent =
      Evaluated({{.success = false, .error_mm = 30, .frames = 99},
                 {.success = false, .error_mm = 30, .frames = 99}});
  const EvaluationSummary candidate =
      Evaluated({{.success = true, .error_mm = 90},
                 {.success = false, .error_mm = 90, .frames = 10}});

  const PromotionVerdict verdict = JudgePromotion(candidate, incumbent, kRule);

  EXPECT_TRUE(verdict.promoted) << verdict.reason;
  EXPECT_EQ(verdict.common.clips, 0);
}

TEST(Promotion, ComparesTheFramesReachedWhereNothingIsWon) {
  const auto falls_at = [](int frame) {
    return Evaluated({{.success = false, .error_mm = 80, .frames = frame}});
  };

  EXPECT_TRUE(JudgePromotion(falls_at(60), falls_at(50), kRule).promoted);
  EXPECT_TRUE(JudgePromotion(falls_at(49), falls_at(50), kRule).promoted);
  const PromotionVerdict sooner =
      JudgePromotion(falls_at(48), falls_at(50), kRule);

  EXPECT_FALSE(sooner.promoted);
  EXPECT_EQ(sooner.reason,
            "frames reached (no clip is won by both): expected at least 49.0 % "
            "(the incumbent's 50.0 less 1.0), found 48.0 %");
}

TEST(Promotion, TakesTheFirstOne) {
  EXPECT_TRUE(JudgePromotion(Figures(0, 500), std::nullopt, kRule).promoted);
}

TEST(Promotion, RefusesWhatWasComparedWithNothing) {
  const EvaluationSummary nothing =
      Evaluated({{.success = true, .error_mm = 0, .frames = 0}});

  EXPECT_FALSE(JudgePromotion(nothing, std::nullopt, kRule).promoted);
  EXPECT_FALSE(JudgePromotion(nothing, Figures(50, 80), kRule).promoted);
  EXPECT_TRUE(JudgePromotion(Figures(100, 20), nothing, kRule).promoted);
}

TEST(Promotion, RefusesFiguresThatAreNoNumbers) {
  EvaluationSummary no_share = Figures(100, 40);
  no_share.overall.success_rate = NAN;

  EXPECT_FALSE(
      JudgePromotion(Figures(100, NAN), Figures(100, 40), kRule).promoted);
  EXPECT_FALSE(JudgePromotion(no_share, Figures(100, 40), kRule).promoted);
}

TEST(PromotionRule, NamesTheToleranceThatIsNone) {
  EXPECT_THAT(kRule.Validate(), IsOk());
  EXPECT_THAT((PromotionRule{.success_tolerance = 1.5}).Validate(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("success-tolerance: expected 0 to 1")));
  EXPECT_THAT((PromotionRule{.error_tolerance = -0.1}).Validate(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("error-tolerance: expected >= 0")));
  EXPECT_THAT((PromotionRule{.error_tolerance = NAN}).Validate(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("error-tolerance")));
}

}  // namespace
}  // namespace sinew::tools
