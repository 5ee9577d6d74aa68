#include "learner/ppo/ppo_update.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "absl/status/status.h"
#include "common/status_macros.h"
#include "learner/ppo/minibatches.h"
#include "learner/update/gradient_scale.h"

namespace sinew::learner {
namespace {

// Sums of a minibatch over its shards.
struct MinibatchFigures {
  GradientFigures network[kNumNetworks];
};

class Epochs {
 public:
  Epochs(const UpdateSettings& settings, const Batch& batch,
         PpoNetworks& networks, RankPool& pool)
      : settings_(settings),
        batch_(batch),
        networks_(networks),
        pool_(pool),
        first_(settings.policy_learns ? 0
                                      : static_cast<int>(NetworkId::kValue)),
        order_(batch.rows()) {}

  absl::StatusOr<UpdateFigures> Run() {
    for (int epoch = 0; epoch < settings_.epochs && !stopped_; ++epoch) {
      Shuffle(epoch);
      for (int64_t begin = 0; begin < batch_.rows() && !stopped_;
           begin += settings_.minibatch) {
        const bool measure = epoch > 0 && begin == 0;
        SINEW_RETURN_IF_ERROR(Minibatch(begin, measure));
      }
      if (!stopped_) ++figures_.epochs;
    }
    if (!stopped_ && settings_.policy_learns) {
      SINEW_RETURN_IF_ERROR(MeasureKl());
    }
    return Means();
  }

 private:
  void Shuffle(int epoch) {
    ShuffleRows(settings_.seed, settings_.iteration, epoch, order_);
  }

  absl::Span<const int64_t> ShardRows(int64_t begin, int shard) const {
    const int64_t size = settings_.minibatch / settings_.shards;
    return {&order_[begin + shard * size], static_cast<size_t>(size)};
  }

  // Of a minibatch: the sum of a column of zeros and ones.
  double Count(absl::Span<const float> column, int64_t begin) const {
    double count = 0;
    for (int64_t i = begin; i < begin + settings_.minibatch; ++i) {
      count += column[order_[i]];
    }
    return count;
  }
  // That, but nothing is divided by 0: sums over no rows are 0.
  double ActedRows(int64_t begin) const {
    return std::max(1.0, Count(batch_.acted(), begin));
  }

  absl::Status Minibatch(int64_t begin, bool measure) {
    const double valid = Count(batch_.weight(), begin);
    if (valid == 0) return absl::OkStatus();
    const double acted = ActedRows(begin);
    SINEW_ASSIGN_OR_RETURN(const MinibatchFigures sums,
                           Gradients(begin, 1 / valid));
    const GradientFigures& policy = sums.network[0];
    const GradientFigures& value = sums.network[1];
    if (measure && policy.kl / acted > settings_.kl_stop) {
      stopped_ = true;
      figures_.kl = policy.kl / acted;
      return absl::OkStatus();
    }
    if (!std::isfinite(policy.loss) || !std::isfinite(value.loss)) {
      ++figures_.non_finite;
      return absl::OkStatus();
    }
    ++minibatches_;
    figures_.policy_loss += policy.loss;
    figures_.value_loss += value.loss;
    figures_.entropy += policy.entropy / valid;
    figures_.clip_fraction += policy.clipped / acted;
    figures_.latent_kl += policy.latent_kl / valid;
    return Step();
  }

  absl::StatusOr<MinibatchFigures> Gradients(int64_t begin, double scale) {
    const int shards = settings_.shards;
    const int tasks = (kNumNetworks - first_) * shards;
    std::vector<GradientFigures> parts(tasks);
    SINEW_RETURN_IF_ERROR(pool_.TryRun(tasks, [&](int task) -> absl::Status {
      const auto network = static_cast<NetworkId>(first_ + task / shards);
      const int shard = task % shards;
      SINEW_ASSIGN_OR_RETURN(
          parts[task],
          networks_.Gradient(network, shard, ShardRows(begin, shard), scale));
      return absl::OkStatus();
    }));
    MinibatchFigures sums;
    for (int task = 0; task < tasks; ++task) {
      GradientFigures& sum = sums.network[first_ + task / shards];
      sum.loss += parts[task].loss;
      sum.kl += parts[task].kl;
      sum.clipped += parts[task].clipped;
      sum.entropy += parts[task].entropy;
      sum.latent_kl += parts[task].latent_kl;
    }
    for (int network = first_; network < kNumNetworks; ++network) {
      const NetworkFlops flops =
          networks_.flops(static_cast<NetworkId>(network));
      figures_.flops += static_cast<double>(settings_.minibatch) *
                        (flops.forward + flops.backward);
    }
    return sums;
  }

  absl::Status Step() {
    double norms[kNumNetworks] = {0, 0};
    SINEW_RETURN_IF_ERROR(
        pool_.TryRun(kNumNetworks - first_, [&](int task) -> absl::Status {
          const auto network = static_cast<NetworkId>(first_ + task);
          double& norm = norms[first_ + task];
          SINEW_ASSIGN_OR_RETURN(norm, networks_.SumGradients(network));
          if (!std::isfinite(norm)) return absl::OkStatus();
          const double scale = GradientScale(norm, settings_.max_gradient_norm);
          return networks_.Step(network, settings_.learning_rate[first_ + task],
                                scale);
        }));
    if (!std::isfinite(norms[0]) || !std::isfinite(norms[1])) {
      ++figures_.non_finite;
      return absl::OkStatus();
    }
    ++steps_;
    for (int i = 0; i < kNumNetworks; ++i)
      figures_.gradient_norm[i] += norms[i];
    return absl::OkStatus();
  }

  absl::Status MeasureKl() {
    Shuffle(settings_.epochs);
    const double valid = Count(batch_.weight(), 0);
    if (valid == 0) return absl::OkStatus();
    const double acted = ActedRows(0);
    std::vector<double> parts(settings_.shards);
    SINEW_RETURN_IF_ERROR(
        pool_.TryRun(settings_.shards, [&](int shard) -> absl::Status {
          SINEW_ASSIGN_OR_RETURN(
              const GradientFigures figures,
              networks_.PolicyFigures(ShardRows(0, shard), 1 / valid));
          parts[shard] = figures.kl;
          return absl::OkStatus();
        }));
    for (const double part : parts) figures_.kl += part / acted;
    figures_.flops += static_cast<double>(settings_.minibatch) *
                      networks_.flops(NetworkId::kPolicy).forward;
    return absl::OkStatus();
  }

  UpdateFigures Means() {
    const double minibatches = std::max(1, minibatches_);
    figures_.policy_loss /= minibatches;
    figures_.value_loss /= minibatches;
    figures_.entropy /= minibatches;
    figures_.clip_fraction /= minibatches;
    figures_.latent_kl /= minibatches;
    for (double& norm : figures_.gradient_norm) norm /= std::max(1, steps_);
    return figures_;
  }

  const UpdateSettings& settings_;
  const Batch& batch_;
  PpoNetworks& networks_;
  RankPool& pool_;
  const int first_;             // of the networks that learn, to the last
  std::vector<int64_t> order_;  // rows as the epoch takes them
  UpdateFigures figures_;
  int minibatches_ = 0;  // with finite losses
  int steps_ = 0;
  bool stopped_ = false;
};

}  // namespace

absl::StatusOr<UpdateFigures> RunEpochs(const UpdateSettings& settings,
                                        const Batch& batch,
                                        PpoNetworks& networks, RankPool& pool) {
  return Epochs(settings, batch, networks, pool).Run();
}

}  // namespace sinew::learner
