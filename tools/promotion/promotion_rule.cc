#include "tools/promotion/promotion_rule.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace sinew::tools {
namespace {

// Tolerances are inclusive, whatever the last bit of a difference.
constexpr double kRounding = 1e-9;

}  // namespace

absl::Status PromotionRule::Validate() const {
  if (!(success_tolerance >= 0 && success_tolerance <= 1)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "success-tolerance: expected 0 to 1, found ", success_tolerance));
  }
  if (!(error_tolerance >= 0) || std::isinf(error_tolerance)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "error-tolerance: expected >= 0, found ", error_tolerance));
  }
  return absl::OkStatus();
}

PromotionVerdict JudgePromotion(const SetSummary& candidate,
                                const std::optional<SetSummary>& incumbent,
                                const PromotionRule& rule) {
  if (candidate.frames == 0) {
    return {.promoted = false,
            .reason = "E_g-mpjpe: expected frames to compare, found none"};
  }
  if (!incumbent) return {.promoted = true, .reason = "there is no incumbent"};
  const double least = incumbent->success_rate - rule.success_tolerance;
  if (!(candidate.success_rate >= least - kRounding)) {
    return {.promoted = false,
            .reason = absl::StrFormat(
                "success rate: expected at least %.1f %% (the incumbent's %.1f "
                "less %.1f), found %.1f %%",
                100 * least, 100 * incumbent->success_rate,
                100 * rule.success_tolerance, 100 * candidate.success_rate)};
  }
  const double most =
      incumbent->means.e_g_mpjpe_mm * (1 + rule.error_tolerance);
  if (incumbent->frames > 0 &&
      !(candidate.means.e_g_mpjpe_mm <= most + kRounding)) {
    return {.promoted = false,
            .reason = absl::StrFormat(
                "E_g-mpjpe: expected at most %.2f mm (the incumbent's %.2f and "
                "%.1f %% more), found %.2f mm",
                most, incumbent->means.e_g_mpjpe_mm, 100 * rule.error_tolerance,
                candidate.means.e_g_mpjpe_mm)};
  }
  return {.promoted = true,
          .reason = "no worse than the incumbent within the tolerances"};
}

}  // namespace sinew::tools
