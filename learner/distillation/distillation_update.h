#ifndef SINEW_LEARNER_DISTILLATION_DISTILLATION_UPDATE_H_
#define SINEW_LEARNER_DISTILLATION_DISTILLATION_UPDATE_H_

#include <cstdint>

#include "absl/status/statusor.h"
#include "common/segment/mirror.h"
#include "learner/distillation/distillation_networks.h"
#include "learner/memory/memory.h"
#include "learner/update/rank_pool.h"

namespace sinew::learner {

struct DistillationSettings {
  uint64_t seed = 0;
  SequenceShape shape;
  int64_t minibatch = 1;  // rows: whole sequences, a multiple of shards of them
  int shards = 1;
  double learning_rate = 0;
  double max_gradient_norm = 0;
  double kl_weight = 0;
  double continuity_weight = 0;
  // If not null, half of the sequences are taken as their mirror images.
  const SegmentMirror* mirror = nullptr;  // borrowed
};

// Means over minibatches with a finite loss, unless said otherwise.
struct MinibatchFigures {
  int minibatches = 0;
  double loss = 0;
  double action = 0, latent_kl = 0, continuity = 0;
  double action_error_rad = 0;  // root of the mean square over their rows
  double gradient_norm = 0;     // before clipping
  int64_t non_finite = 0;       // minibatches skipped
  double flops = 0;             // of all
};

// The minibatches that the memory's samples-to-insert ratio allows now:
//
//   while one is due: select sequences, gather them, some mirrored
//     per shard on the ranks: noise of the latents, gradient of the loss
//     a loss or a norm that is not finite: skip it and count
//     sum the shards' gradients in order, clip their norm, one step
//     each sequence's priority becomes the mean action loss of its valid rows;
//     the least one where that is not finite
//
// A sequence that is drawn twice in a minibatch counts twice. Noise, selection
// and mirroring are functions of (seed, rows sampled so far), so every number
// is one of networks, memory and settings; the number of ranks has no part in
// it.
//
// Thread-safety: one caller. Blocking: computes. Errors: those of
// DistillationNetworks; the update has then been done in part.
absl::StatusOr<MinibatchFigures> RunMinibatches(
    const DistillationSettings& settings, Memory& memory,
    DistillationNetworks& networks, RankPool& pool);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_DISTILLATION_DISTILLATION_UPDATE_H_
