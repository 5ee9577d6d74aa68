#ifndef SINEW_TOOLS_PROMOTION_PROMOTION_RULE_H_
#define SINEW_TOOLS_PROMOTION_PROMOTION_RULE_H_

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "common/evaluation/evaluation_summary.h"

namespace sinew::tools {

// When a new bundle may take the place of the stable one. With s the share of
// clips that succeed, r the share of frames reached, and e the E_g-mpjpe over
// the frames of the clips that both win, evaluated on the same clips and
// starts:
//
//   s_candidate >= s_incumbent - success_tolerance   and
//   e_candidate <= e_incumbent (1 + error_tolerance)
//
// Other clips have no say in e: a rollout ends where it fails, so whoever
// survives longer has the far-off frames as well, and its mean over all frames
// is the larger one. Where no clip is won by both there is no e; instead of
// the second line it then takes
//
//   s_candidate > s_incumbent   or
//   r_candidate >= r_incumbent - success_tolerance
//
// Without an incumbent any candidate that was compared with anything may. A
// candidate none of whose frames was compared may not.
//
// Thread-safety: pure. Blocking: never. Errors: Validate names the flag.
struct PromotionRule {
  // Share of clips (of r: of frames), [0, 1]: one in a hundred may be lost to
  // chance.
  double success_tolerance = 0.01;
  // Share of the incumbent's error, >= 0.
  double error_tolerance = 0.02;

  absl::Status Validate() const;
};

// E_g-mpjpe of both over all frames of the clips that both win.
struct CommonErrors {
  int clips = 0;  // that both win; 0: there are no errors
  double candidate_mm = 0;
  double incumbent_mm = 0;
};

struct PromotionVerdict {
  bool promoted = false;
  // Why, in a line: figures, expected and found.
  std::string reason = {};
  CommonErrors common = {};  // what was compared; no clips without an incumbent
};

// Both summaries are of the same clips.
PromotionVerdict JudgePromotion(
    const EvaluationSummary& candidate,
    const std::optional<EvaluationSummary>& incumbent,
    const PromotionRule& rule);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_PROMOTION_PROMOTION_RULE_H_
