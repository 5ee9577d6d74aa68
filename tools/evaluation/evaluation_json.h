#ifndef SINEW_TOOLS_EVALUATION_EVALUATION_JSON_H_
#define SINEW_TOOLS_EVALUATION_EVALUATION_JSON_H_

#include <optional>
#include <string>

#include "deploy/bundle/clip_uses.h"
#include "tools/evaluation/evaluation.h"
#include "tools/evaluation/subject.h"

namespace sinew::evaluation {

// Where the subject came from, as the user wrote it.
struct EvaluationSource {
  std::string bundle;           // folder; empty: the zero action alone
  std::string manifest_sha256;  // of the bundle's manifest.json
  std::string motions;          // library folder
  // Clips that the library's import turned away (rejected_clips.h).
  std::optional<int> rejected_clips = std::nullopt;
  // What the bundle says of its clips; empty: nothing.
  bundle::ClipUses clip_uses = {};
};

// The file that `sinew eval` writes: JSON, two spaces, ends with a newline.
//
//   overall, successful, zero_action
//             sets of clips: clips, succeeded_clips, success_rate,
//             first_start_successes (clips that survive from their first
//             frame), starts, succeeded_starts, survived_share, frames,
//             e_g_mpjpe_mm, e_mpjpe_mm, e_acc, e_vel, body_mm (in the order of
//             `bodies`). Errors are null where no frame was compared.
//   training, left_out
//             the same of the clips that are trained on and of those that are
//             left out, each with `successful` and `zero_action`; only where
//             some are left out (their clips have `left_out`).
//   imported  clips, rejected_clips, succeeded_clips, success_rate over all
//             that was imported: what the import turned away has failed. Only
//             where the library's folder says how many these are.
//   clips     per clip: name, success, first_start_success, starts,
//             succeeded_starts, frames, failed_at_frame, the four errors,
//             body_mm, `zero_action` with the same fields, and for the first
//             clips `profile`: error of each body over the clip, {seconds,
//             body_mm[body][bin]}. Where the bundle says so also `use`, what
//             the clip was to its training: WordsOf
//             (deploy/bundle/clip_uses.h), or "not in training" of a clip that
//             it does not name. Sets go by the library's `left_out`.
//   fallen    only where it was asked for: starts, seed, clips, seconds,
//             reference_stands_seconds, recovered_3_s, recovered_5_s,
//             rows of {state, clip, recovered_s, carried_s, seconds},
//             `zero_action` with the two shares; where the library has get-ups
//             `get_up` with the last five (fallen_figures.h).
//   randomised
//             {seed}, only where the recipe randomises evaluations.
//   seconds, starts_per_clip, frames_per_second, bodies, bundle, library,
//   definitions
//
// Pure: equal arguments give equal bytes.
std::string EvaluationJson(const Subject& subject,
                           const EvaluationOptions& options,
                           const EvaluationSource& source,
                           const Evaluation& evaluation);

}  // namespace sinew::evaluation

#endif  // SINEW_TOOLS_EVALUATION_EVALUATION_JSON_H_
