#include "tools/promotion/promotion_rule.h"

#include <cmath>
#include <optional>

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

SetSummary Figures(double success_rate, double error_mm) {
  SetSummary set;
  set.frames = 100;
  set.success_rate = success_rate;
  set.means.e_g_mpjpe_mm = error_mm;
  return set;
}

TEST(Promotion, TakesWhatIsBetter) {
  EXPECT_TRUE(JudgePromotion(Figures(1, 30), Figures(0.9, 40), kRule).promoted);
}

TEST(Promotion, TakesWhatIsAsGood) {
  const SetSummary same = Figures(0.97, 33);

  EXPECT_TRUE(JudgePromotion(same, same, kRule).promoted);
  EXPECT_TRUE(JudgePromotion(same, same, {0, 0}).promoted);
}

TEST(Promotion, ToleratesWhatTheRuleStatesAndNoMore) {
  const SetSummary incumbent = Figures(0.95, 40);

  // 0.95 - 0.01 = 0.94; 40 * 1.02 = 40.8.
  EXPECT_TRUE(JudgePromotion(Figures(0.94, 40.8), incumbent, kRule).promoted);
  const PromotionVerdict fewer =
      JudgePromotion(Figures(0.939, 10), incumbent, kRule);
  const PromotionVerdict further =
      JudgePromotion(Figures(1, 40.9), incumbent, kRule);

  EXPECT_FALSE(fewer.promoted);
  EXPECT_EQ(fewer.reason,
            "success rate: expected at least 94.0 % (the incumbent's 95.0 less "
            "1.0), found 93.9 %");
  EXPECT_FALSE(further.promoted);
  EXPECT_EQ(further.reason,
            "E_g-mpjpe: expected at most 40.80 mm (the incumbent's 40.00 and "
            "2.0 % more), found 40.90 mm");
}

TEST(Promotion, TakesTheFirstOne) {
  EXPECT_TRUE(JudgePromotion(Figures(0, 500), std::nullopt, kRule).promoted);
}

TEST(Promotion, RefusesWhatWasComparedWithNothing) {
  SetSummary nothing = Figures(1, 0);
  nothing.frames = 0;

  EXPECT_FALSE(JudgePromotion(nothing, std::nullopt, kRule).promoted);
  EXPECT_FALSE(JudgePromotion(nothing, Figures(0.5, 80), kRule).promoted);
  EXPECT_TRUE(JudgePromotion(Figures(1, 20), nothing, kRule).promoted);
}

TEST(Promotion, RefusesFiguresThatAreNoNumbers) {
  EXPECT_FALSE(JudgePromotion(Figures(1, NAN), Figures(1, 40), kRule).promoted);
  EXPECT_FALSE(
      JudgePromotion(Figures(NAN, 40), Figures(1, 40), kRule).promoted);
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
