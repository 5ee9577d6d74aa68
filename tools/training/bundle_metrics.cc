#include "tools/training/bundle_metrics.h"

namespace sinew::tools {

v1::BundleMetrics MakeBundleMetrics(const EvaluationSummary& summary,
                                    int64_t iteration) {
  v1::BundleMetrics metrics;
  const SetSummary& training = summary.training;
  metrics.set_clips(training.clips);
  metrics.set_starts(training.starts);
  metrics.set_succeeded_starts(training.succeeded_starts);
  metrics.set_success_rate(training.success_rate);
  metrics.set_e_g_mpjpe_mm(training.means.e_g_mpjpe_mm);
  metrics.set_e_mpjpe_mm(training.means.e_mpjpe_mm);
  metrics.set_e_acc(training.means.e_acc);
  metrics.set_e_vel(training.means.e_vel);
  metrics.set_iteration(iteration);
  const SetSummary& left_out = summary.left_out;
  metrics.set_left_out_clips(left_out.clips);
  metrics.set_left_out_starts(left_out.starts);
  metrics.set_left_out_succeeded_starts(left_out.succeeded_starts);
  metrics.set_left_out_success_rate(left_out.success_rate);
  metrics.set_left_out_e_g_mpjpe_mm(left_out.means.e_g_mpjpe_mm);
  metrics.set_left_out_e_mpjpe_mm(left_out.means.e_mpjpe_mm);
  metrics.set_left_out_e_acc(left_out.means.e_acc);
  metrics.set_left_out_e_vel(left_out.means.e_vel);
  return metrics;
}

}  // namespace sinew::tools
