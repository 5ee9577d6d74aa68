#include "learner/distillation/distillation_update.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "common/random/philox.h"
#include "common/status_macros.h"
#include "learner/update/gradient_scale.h"

namespace sinew::learner {
namespace {

using Figures = DistillationNetworks::Figures;

// What a shard computes with; kept between minibatches.
struct Buffers {
  std::vector<float> observation, noise, label, valid, linked;
};

void Append(absl::Span<const float> values, std::vector<float>& into) {
  into.insert(into.end(), values.begin(), values.end());
}

// Rows of the mirror's width.
void AppendMirrored(const RowMirror& mirror, absl::Span<const float> rows,
                    std::vector<float>& into) {
  const size_t width = mirror.width();
  const size_t begin = into.size();
  into.resize(begin + rows.size());
  for (size_t at = 0; at < rows.size(); at += width) {
    mirror.Apply(rows.subspan(at, width),
                 absl::MakeSpan(into).subspan(begin + at, width));
  }
}

double Sum(absl::Span<const float> values) {
  double sum = 0;
  for (const float value : values) sum += value;
  return sum;
}

class Minibatches {
 public:
  Minibatches(const DistillationSettings& settings, Memory& memory,
              DistillationNetworks& networks, RankPool& pool)
      : settings_(settings),
        memory_(memory),
        networks_(networks),
        pool_(pool),
        buffers_(settings.shards),
        parts_(settings.shards) {}

  absl::StatusOr<MinibatchFigures> Run() {
    for (int64_t due = memory_.DueMinibatches(settings_.minibatch); due > 0;
         --due) {
      // Of all minibatches of the run.
      const uint64_t draw = memory_.sampled_rows() / settings_.minibatch;
      selected_ =
          memory_.Select(settings_.minibatch / settings_.shape.steps, draw);
      if (selected_.empty()) break;
      SINEW_RETURN_IF_ERROR(RunOne(draw));
      memory_.CountSampled(settings_.minibatch);
    }
    return Means();
  }

 private:
  absl::Span<const Memory::Reference> ShardOf(int shard) const {
    const size_t size = selected_.size() / settings_.shards;
    return absl::MakeConstSpan(selected_).subspan(shard * size, size);
  }

  absl::Status RunOne(uint64_t draw) {
    double valid = 0, linked = 0;
    for (const Memory::Reference& reference : selected_) {
      const Memory::Sequence sequence = memory_.At(reference);
      valid += Sum(sequence.valid);
      linked += Sum(sequence.linked);
    }
    if (valid == 0) return absl::OkStatus();
    const DistillationNetworks::Weights weights = {
        .kl = settings_.kl_weight,
        .continuity = settings_.continuity_weight,
        .row_scale = 1 / valid,
        .pair_scale = 1 / std::max(1.0, linked)};
    SINEW_RETURN_IF_ERROR(
        pool_.TryRun(settings_.shards, [&](int shard) -> absl::Status {
          SINEW_ASSIGN_OR_RETURN(
              parts_[shard],
              networks_.Gradient(shard, Gather(draw, shard), weights));
          return absl::OkStatus();
        }));
    figures_.flops +=
        static_cast<double>(settings_.minibatch) * networks_.flops_per_row();
    return Learn(valid);
  }

  DistillationNetworks::Rows Gather(uint64_t draw, int shard) {
    Buffers& buffers = buffers_[shard];
    for (auto* buffer : {&buffers.observation, &buffers.label, &buffers.valid,
                         &buffers.linked}) {
      buffer->clear();
    }
    const absl::Span<const Memory::Reference> references = ShardOf(shard);
    for (size_t i = 0; i < references.size(); ++i) {
      const Memory::Sequence sequence = memory_.At(references[i]);
      if (IsMirrored(draw, shard * references.size() + i)) {
        AppendMirrored(settings_.mirror->observation, sequence.observation,
                       buffers.observation);
        AppendMirrored(settings_.mirror->action, sequence.label, buffers.label);
      } else {
        Append(sequence.observation, buffers.observation);
        Append(sequence.label, buffers.label);
      }
      Append(sequence.valid, buffers.valid);
      Append(sequence.linked, buffers.linked);
    }
    buffers.noise.resize(buffers.valid.size() * networks_.latent_width());
    FillNormal({.seed = settings_.seed,
                .environment = draw,
                .episode = static_cast<uint64_t>(shard),
                .purpose = RandomPurpose::kLatentNoise},
               absl::MakeSpan(buffers.noise));
    return {.observation = buffers.observation,
            .noise = buffers.noise,
            .label = buffers.label,
            .valid = buffers.valid,
            .linked = buffers.linked};
  }

  // Whether that sequence of the minibatch is.
  bool IsMirrored(uint64_t draw, uint64_t sequence) const {
    return settings_.mirror != nullptr &&
           Uniform({.seed = settings_.seed,
                    .environment = draw,
                    .episode = sequence,
                    .purpose = RandomPurpose::kMirror}) < 0.5;
  }

  absl::Status Learn(double valid) {
    Figures sum;
    for (const Figures& part : parts_) {
      sum.loss += part.loss;
      sum.action += part.action;
      sum.latent_kl += part.latent_kl;
      sum.continuity += part.continuity;
      sum.squared_error_rad2 += part.squared_error_rad2;
    }
    double norm = 0;
    const bool finite = std::isfinite(sum.loss);
    if (finite) SINEW_RETURN_IF_ERROR(Step(norm));
    if (!finite || !std::isfinite(norm)) {
      ++figures_.non_finite;
      SetPriorities(/*learnt=*/false);
      return absl::OkStatus();
    }
    ++figures_.minibatches;
    figures_.loss += sum.loss;
    figures_.action += sum.action;
    figures_.latent_kl += sum.latent_kl;
    figures_.continuity += sum.continuity;
    figures_.gradient_norm += norm;
    squares_ += sum.squared_error_rad2;
    numbers_ += valid * static_cast<double>(settings_.shape.action);
    SetPriorities(/*learnt=*/true);
    return absl::OkStatus();
  }

  absl::Status Step(double& norm) {
    return pool_.TryRun(1, [&](int) -> absl::Status {
      SINEW_ASSIGN_OR_RETURN(norm, networks_.SumGradients());
      if (!std::isfinite(norm)) return absl::OkStatus();
      return networks_.Step(settings_.learning_rate,
                            GradientScale(norm, settings_.max_gradient_norm));
    });
  }

  // Those that nothing can be learnt from must not be drawn again and again.
  void SetPriorities(bool learnt) {
    for (int shard = 0; shard < settings_.shards; ++shard) {
      const auto sequences = ShardOf(shard);
      for (size_t i = 0; i < sequences.size(); ++i) {
        if (Sum(memory_.At(sequences[i]).valid) == 0) continue;
        const float loss = parts_[shard].sequence_loss[i];
        if (!std::isfinite(loss)) {
          memory_.SetPriority(sequences[i], 0);
        } else if (learnt) {
          memory_.SetPriority(sequences[i], loss);
        }
      }
    }
  }

  MinibatchFigures Means() {
    const double count = std::max(1, figures_.minibatches);
    figures_.loss /= count;
    figures_.action /= count;
    figures_.latent_kl /= count;
    figures_.continuity /= count;
    figures_.gradient_norm /= count;
    figures_.action_error_rad = std::sqrt(squares_ / std::max(1.0, numbers_));
    return figures_;
  }

  const DistillationSettings& settings_;
  Memory& memory_;
  DistillationNetworks& networks_;
  RankPool& pool_;
  std::vector<Buffers> buffers_;  // by shard
  std::vector<Figures> parts_;    // likewise
  std::vector<Memory::Reference> selected_;
  MinibatchFigures figures_;
  double squares_ = 0, numbers_ = 0;  // of errors, rad^2
};

}  // namespace

absl::StatusOr<MinibatchFigures> RunMinibatches(
    const DistillationSettings& settings, Memory& memory,
    DistillationNetworks& networks, RankPool& pool) {
  return Minibatches(settings, memory, networks, pool).Run();
}

}  // namespace sinew::learner
