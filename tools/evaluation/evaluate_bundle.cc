#include "tools/evaluation/evaluate_bundle.h"

#include <optional>
#include <utility>

#include "common/files.h"
#include "common/output_file.h"
#include "common/status_macros.h"
#include "deploy/bundle/clip_uses.h"
#include "tools/evaluation/bundle_subject.h"
#include "tools/evaluation/evaluation_json.h"
#include "tools/evaluation/rejected_clips.h"

namespace sinew::evaluation {

absl::StatusOr<EvaluationFigures> EvaluateBundle(
    const std::string& bundle, const std::string& motions,
    const std::string& out, const EvaluationOptions& options,
    const StopToken& stop) {
  SINEW_RETURN_IF_ERROR(CheckOutputFile(out));
  if (options.fallen) {
    SINEW_RETURN_IF_ERROR(CheckFallenStarts(*options.fallen));
  }
  SINEW_ASSIGN_OR_RETURN(
      const BundleSubject loaded,
      LoadBundleSubject(bundle, motions, options.fallen.value_or(0),
                        options.max_mean_body_distance));
  std::optional<FallenEvaluation> fallen;
  if (options.fallen) {  // before what takes long: a library may not be fit
    SINEW_ASSIGN_OR_RETURN(
        fallen, EvaluateFallen(loaded.subject, options.threads, stop));
  }
  SINEW_ASSIGN_OR_RETURN(Evaluation evaluation,
                         Evaluate(loaded.subject, options, stop));
  evaluation.fallen = fallen;
  SINEW_ASSIGN_OR_RETURN(
      const auto rejected,
      RejectedClips(motions, loaded.subject.library().manifest().clips_size()));
  const EvaluationSource source = {
      .bundle = bundle,
      .manifest_sha256 = loaded.manifest.manifest_sha256(),
      .motions = motions,
      .rejected_clips = rejected
                            ? std::optional(static_cast<int>(rejected->size()))
                            : std::nullopt,
      .clip_uses = bundle::ClipUsesOf(loaded.manifest.provenance())};
  SINEW_RETURN_IF_ERROR(WriteFileAtomically(
      out, EvaluationJson(loaded.subject, options, source, evaluation)));
  return EvaluationFigures{.policy = std::move(evaluation.policy),
                           .zero_action = std::move(evaluation.zero_action),
                           .fallen = fallen,
                           .rejected_clips = source.rejected_clips};
}

}  // namespace sinew::evaluation
