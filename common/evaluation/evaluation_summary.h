#ifndef SINEW_COMMON_EVALUATION_EVALUATION_SUMMARY_H_
#define SINEW_COMMON_EVALUATION_EVALUATION_SUMMARY_H_

#include <cstdint>
#include <vector>

#include "absl/types/span.h"
#include "proto/sinew/v1/motion.pb.h"
#include "proto/sinew/v1/rollout.pb.h"

namespace sinew {

// Means over all frames of a set of results (long motions weigh more, as in
// the papers); 0 where there are no frames. Definitions:
// sim/metrics/tracking_errors.h.
struct MetricMeans {
  double e_g_mpjpe_mm = 0;
  double e_mpjpe_mm = 0;
  double e_vel = 0;  // mm/frame at 30 Hz
  double e_acc = 0;  // mm/frame^2 at 30 Hz
  // Frames that e_vel and e_acc are means over: fewer than all, as these take
  // two and three frames in a row.
  int64_t velocity_frames = 0;
  int64_t acceleration_frames = 0;
};

// All starts of one clip.
struct ClipSummary {
  int32_t clip = 0;
  bool left_out = false;             // of training
  bool success = false;              // all its starts succeeded
  bool first_start_success = false;  // its start on the earliest frame did
  int32_t starts = 0;
  int32_t succeeded_starts = 0;
  int64_t frames = 0;            // compared, over all starts
  int32_t failed_at_frame = -1;  // earliest failure, counted from its start
  MetricMeans means;
  std::vector<double> body_mm;  // [B] mean error of each tracked body
};

// A set of clips.
struct SetSummary {
  int32_t clips = 0;
  int32_t succeeded_clips = 0;        // by all their starts
  int32_t first_start_successes = 0;  // clips by their start on the earliest
                                      // frame
  int32_t starts = 0;
  int32_t succeeded_starts = 0;
  int64_t frames = 0;
  double success_rate = 0;    // succeeded clips / clips
  double survived_share = 0;  // frames reached / frames asked for
  MetricMeans means;
  std::vector<double> body_mm;
};

struct EvaluationSummary {
  SetSummary overall;
  SetSummary successful;  // of the clips that succeeded
  SetSummary training;    // of the clips that are trained on
  SetSummary left_out;    // of the others
  // Of each of these two, the clips that succeeded: what the papers' errors are
  // means over.
  SetSummary training_successful;
  SetSummary left_out_successful;
  std::vector<ClipSummary> clips;  // in clip order; those with results
};

// Whether each clip of a library is left out of training. Pure.
std::vector<bool> LeftOutClips(const v1::MotionLibrary& library);

// Summary of results in any order; equal for every order of them, bit for bit.
// `left_out`: by clip; clips past its end are trained on. Pure.
EvaluationSummary SummariseEvaluation(
    absl::Span<const v1::EvaluationResult> results,
    const std::vector<bool>& left_out = {});

}  // namespace sinew

#endif  // SINEW_COMMON_EVALUATION_EVALUATION_SUMMARY_H_
