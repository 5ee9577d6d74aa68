#include "tools/training/best_policy.h"

#include <cstddef>
#include <utility>

#include "common/build_info.h"
#include "common/status_macros.h"

namespace sinew::tools {
namespace {

// evaluation.delay is at most 2.
constexpr size_t kRemembered = 3;

// `evaluated` says which iteration it is of.
void Fill(const EvaluationSummary& summary, v1::EvaluatedPolicy& evaluated) {
  // What is left out of training chooses nothing.
  const SetSummary& training = summary.training;
  v1::BundleMetrics& metrics = *evaluated.mutable_metrics();
  metrics.set_clips(training.clips);
  metrics.set_starts(training.starts);
  metrics.set_succeeded_starts(training.succeeded_starts);
  metrics.set_success_rate(training.success_rate);
  metrics.set_e_g_mpjpe_mm(training.means.e_g_mpjpe_mm);
  metrics.set_e_mpjpe_mm(training.means.e_mpjpe_mm);
  metrics.set_e_acc(training.means.e_acc);
  metrics.set_e_vel(training.means.e_vel);
  metrics.set_iteration(evaluated.iteration());
  const SetSummary& left_out = summary.left_out;
  metrics.set_left_out_clips(left_out.clips);
  metrics.set_left_out_starts(left_out.starts);
  metrics.set_left_out_succeeded_starts(left_out.succeeded_starts);
  metrics.set_left_out_success_rate(left_out.success_rate);
  metrics.set_left_out_e_g_mpjpe_mm(left_out.means.e_g_mpjpe_mm);
  evaluated.set_survived_share(training.survived_share);
}

}  // namespace

absl::Status BestPolicy::Load(const std::string& assets_before) {
  SINEW_ASSIGN_OR_RETURN(best_, store_.GetBest());
  if (!best_) return absl::OkStatus();
  if (best_->evaluated.assets_sha256().empty() && !assets_before.empty() &&
      assets_before != assets_sha256_) {
    // From now on it says whose it is, for sessions to come as well.
    best_->evaluated.set_assets_sha256(assets_before);
    SINEW_RETURN_IF_ERROR(store_.PutBest(*best_));
  }
  const std::string& found_for = best_->evaluated.assets_sha256();
  if (!found_for.empty() && found_for != assets_sha256_) best_.reset();
  return absl::OkStatus();
}

void BestPolicy::Remember(int64_t iteration, Blob snapshot, int64_t samples,
                          double train_seconds) {
  RunStore::Policy& policy = recent_.emplace_back();
  policy.evaluated.set_iteration(iteration);
  policy.evaluated.set_samples(samples);
  policy.evaluated.set_train_seconds(train_seconds);
  policy.evaluated.set_build(BuildIdentity());
  policy.evaluated.set_assets_sha256(assets_sha256_);
  policy.snapshot = std::move(snapshot);
  if (recent_.size() > kRemembered) recent_.pop_front();
}

absl::Status BestPolicy::Observe(const learner::IterationReport& report) {
  if (!report.evaluation) return absl::OkStatus();
  for (RunStore::Policy& policy : recent_) {
    if (policy.evaluated.iteration() != report.evaluated_iteration) continue;
    Fill(*report.evaluation, policy.evaluated);
    if (best_ && !IsBetter(policy.evaluated, best_->evaluated)) {
      return absl::OkStatus();
    }
    best_ = policy;
    return store_.PutBest(policy);
  }
  return absl::OkStatus();
}

}  // namespace sinew::tools
