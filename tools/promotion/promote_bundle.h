#ifndef SINEW_TOOLS_PROMOTION_PROMOTE_BUNDLE_H_
#define SINEW_TOOLS_PROMOTION_PROMOTE_BUNDLE_H_

#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "common/evaluation/evaluation_summary.h"
#include "common/stop.h"
#include "deploy/checkpoint/client/artifact_store.h"
#include "tools/evaluation/evaluation.h"
#include "tools/promotion/promotion_rule.h"

namespace sinew::tools {

struct PromotionOptions {
  std::string bundle;   // the candidate's folder
  std::string motions;  // library folder; candidate and incumbent fit it
  // Of the artifact that the candidate becomes; empty: "bundle-" and the first
  // 16 digits of its manifest_sha256.
  std::string id;
  PromotionRule rule;
  // Starts, seconds and threads matter.
  evaluation::EvaluationOptions evaluation;
};

struct Promotion {
  std::string id;            // of the candidate
  std::string incumbent_id;  // empty: there was none
  EvaluationSummary candidate;
  std::optional<EvaluationSummary> incumbent;
  PromotionVerdict verdict;
};

// The gate before `stable` (deploy/checkpoint/stable_bundle.h):
//
//   read the candidate's files and the incumbent's
//   check that the one can follow the other (succession.h)
//   evaluate both on the same starts, which fail at the candidate's
//   evaluation.max_mean_body_distance
//   if the rule holds: put the candidate into the store, move `stable`
//
// A candidate that is refused leaves the store as it is. What is evaluated is
// what is stored: files are read once.
//
// Thread-safety: one caller per store, else the last step may find that
// `stable` has moved (FAILED_PRECONDITION). Blocking: computes; see Evaluate.
// Errors: INVALID_ARGUMENT: rule or options; those of CheckSuccession,
// ReadFolder, ReadBundle, LoadBundleSubject, Evaluate and the store.
absl::StatusOr<Promotion> PromoteBundle(const PromotionOptions& options,
                                        checkpoint::ArtifactStore& store,
                                        const StopToken& stop);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_PROMOTION_PROMOTE_BUNDLE_H_
