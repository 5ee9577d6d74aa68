#ifndef SINEW_TOOLS_PROMOTION_PROMOTION_RULE_H_
#define SINEW_TOOLS_PROMOTION_PROMOTION_RULE_H_

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "common/evaluation/evaluation_summary.h"

namespace sinew::tools {

// When a new bundle may take the place of the stable one. With s the share of
// clips that succeed and e the E_g-mpjpe over all frames, both evaluated on the
// same clips and starts:
//
//   s_candidate >= s_incumbent - success_tolerance   and
//   e_candidate <= e_incumbent (1 + error_tolerance)
//
// Without an incumbent any candidate that was compared with anything may. A
// candidate none of whose frames was compared may not.
//
// Thread-safety: pure. Blocking: never. Errors: Validate names the flag.
struct PromotionRule {
  // Share of clips, [0, 1]: one in a hundred may be lost to chance.
  double success_tolerance = 0.01;
  // Share of the incumbent's error, >= 0.
  double error_tolerance = 0.02;

  absl::Status Validate() const;
};

struct PromotionVerdict {
  bool promoted = false;
  // Why, in a line: figures, expected and found.
  std::string reason;
};

PromotionVerdict JudgePromotion(const SetSummary& candidate,
                                const std::optional<SetSummary>& incumbent,
                                const PromotionRule& rule);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_PROMOTION_PROMOTION_RULE_H_
