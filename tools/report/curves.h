#ifndef SINEW_TOOLS_REPORT_CURVES_H_
#define SINEW_TOOLS_REPORT_CURVES_H_

#include <vector>

#include "tools/report/run_record.h"

namespace sinew::report {

// Points of a curve that a page still draws fast.
inline constexpr int kMaxPoints = 400;

// Training rows as columns for curves, thinned to at most kMaxPoints: a point
// is the mean over neighbouring rows, its position (iteration, wall_s, train_s,
// samples) that of the last of them. Values that no row has are left out:
//
//   {"iteration": [...], "wall_s": [...], ..., "reward": [..., null, ...]}
//
// Derived columns: fail_share (failed / all episodes), tracking_mm (mean body
// distance), samples_per_s, reward_position, _rotation, _linear, _angular.
Json TrainingCurves(const std::vector<Json>& rows);

// Evaluations as columns, all of them: iteration, wall_s, train_s, samples,
// succeeded_share, survived_share, e_g_mpjpe_mm, e_mpjpe_mm, e_vel, e_acc, and
// left_out_succeeded_share where clips are left out of training.
Json EvaluationCurves(const std::vector<Json>& rows);

// Curriculum of training rows, thinned like TrainingCurves: iteration, wall_s,
// train_s, samples; entropy_share, floor_share, largest_clip_share,
// clips_of_half, failure_rate, hardest_share, hardest_failure_rate, hard_clips,
// worst_success (learner/curriculum/curriculum_summary.h). Empty where there is
// one bin alone, or none.
Json CurriculumCurves(const std::vector<Json>& rows);

}  // namespace sinew::report

#endif  // SINEW_TOOLS_REPORT_CURVES_H_
