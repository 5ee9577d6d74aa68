#include "tools/promotion/promotion_rule.h"

#include <cmath>
#include <cstdint>
#include <map>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace sinew::tools {
namespace {

// Tolerances are inclusive, whatever the last bit of a difference.
constexpr double kRounding = 1e-9;

// A mean over frames while it grows.
struct Mean {
  double sum_mm = 0;
  int64_t frames = 0;

  void Add(const ClipSummary& clip) {
    sum_mm += clip.means.e_g_mpjpe_mm * static_cast<double>(clip.frames);
    frames += clip.frames;
  }
  double Value() const { return sum_mm / static_cast<double>(frames); }
};

CommonErrors ErrorsOfClipsThatBothWin(const EvaluationSummary& candidate,
                                      const EvaluationSummary& incumbent) {
  std::map<int32_t, const ClipSummary*> won;
  for (const ClipSummary& clip : incumbent.clips) {
    if (clip.success && clip.frames > 0) won.emplace(clip.clip, &clip);
  }
  CommonErrors common;
  Mean candidates, incumbents;
  for (const ClipSummary& clip : candidate.clips) {
    const auto other = won.find(clip.clip);
    if (other == won.end() || !clip.success || clip.frames == 0) continue;
    ++common.clips;
    candidates.Add(clip);
    incumbents.Add(*other->second);
  }
  if (common.clips == 0) return common;
  common.candidate_mm = candidates.Value();
  common.incumbent_mm = incumbents.Value();
  return common;
}

// These say why not; empty: the rule holds.
std::string ShareRefusal(const char* what, double candidate, double incumbent,
                         double tolerance) {
  const double least = incumbent - tolerance;
  if (candidate >= least - kRounding) return "";
  return absl::StrFormat(
      "%s: expected at least %.1f %% (the incumbent's %.1f less %.1f), found "
      "%.1f %%",
      what, 100 * least, 100 * incumbent, 100 * tolerance, 100 * candidate);
}

std::string ErrorRefusal(const CommonErrors& common, double tolerance) {
  const double most = common.incumbent_mm * (1 + tolerance);
  if (common.candidate_mm <= most + kRounding) return "";
  return absl::StrFormat(
      "E_g-mpjpe of clips that both win (%d): expected at most %.2f mm (the "
      "incumbent's %.2f and %.1f %% more), found %.2f mm",
      common.clips, most, common.incumbent_mm, 100 * tolerance,
      common.candidate_mm);
}

std::string Refusal(const SetSummary& candidate, const SetSummary& incumbent,
                    const CommonErrors& common, const PromotionRule& rule) {
  const std::string refusal =
      ShareRefusal("success rate", candidate.success_rate,
                   incumbent.success_rate, rule.success_tolerance);
  if (!refusal.empty()) return refusal;
  if (common.clips > 0) return ErrorRefusal(common, rule.error_tolerance);
  if (candidate.success_rate > incumbent.success_rate) return "";
  return ShareRefusal("frames reached (no clip is won by both)",
                      candidate.survived_share, incumbent.survived_share,
                      rule.success_tolerance);
}

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

PromotionVerdict JudgePromotion(
    const EvaluationSummary& candidate,
    const std::optional<EvaluationSummary>& incumbent,
    const PromotionRule& rule) {
  if (candidate.overall.frames == 0) {
    return {.reason = "E_g-mpjpe: expected frames to compare, found none"};
  }
  if (!incumbent) return {.promoted = true, .reason = "there is no incumbent"};
  PromotionVerdict verdict = {
      .common = ErrorsOfClipsThatBothWin(candidate, *incumbent)};
  verdict.reason =
      Refusal(candidate.overall, incumbent->overall, verdict.common, rule);
  verdict.promoted = verdict.reason.empty();
  if (verdict.promoted) {
    verdict.reason = "no worse than the incumbent within the tolerances";
  }
  return verdict;
}

}  // namespace sinew::tools
