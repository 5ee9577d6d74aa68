#include "tools/training/best_policy.h"

#include <cstddef>
#include <utility>

#include "common/build_info.h"
#include "common/status_macros.h"
#include "tools/training/bundle_metrics.h"

namespace sinew::tools {
namespace {

// evaluation.delay is at most 2.
constexpr size_t kRemembered = 3;

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
  is_of_others_ = !found_for.empty() && found_for != assets_sha256_;
  if (is_of_others_) best_.reset();
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
    // What is left out of training chooses nothing.
    *policy.evaluated.mutable_metrics() =
        MakeBundleMetrics(*report.evaluation, report.evaluated_iteration);
    policy.evaluated.set_survived_share(
        report.evaluation->training.survived_share);
    if (best_ && !IsBetter(policy.evaluated, best_->evaluated)) {
      return absl::OkStatus();
    }
    best_ = policy;
    return store_.PutBest(policy);
  }
  return absl::OkStatus();
}

}  // namespace sinew::tools
