#ifndef SINEW_LEARNER_PPO_PPO_UPDATE_H_
#define SINEW_LEARNER_PPO_PPO_UPDATE_H_

#include <cstdint>

#include "absl/status/statusor.h"
#include "learner/ppo/batch.h"
#include "learner/ppo/ppo_networks.h"
#include "learner/update/rank_pool.h"

namespace sinew::learner {

struct UpdateSettings {
  uint64_t seed = 0;
  int64_t iteration = 0;
  int epochs = 1;
  int64_t minibatch = 1;  // divides the batch
  int shards = 1;         // divides the minibatch
  double kl_stop = 0;
  double max_gradient_norm = 1;
  double learning_rate[kNumNetworks] = {0, 0};  // policy, value
  // False: the policy stays as it is (ppo.value_warmup_iterations).
  bool policy_learns = true;
};

struct UpdateFigures {
  int epochs = 0;  // begun and not stopped at their first minibatch
  double policy_loss = 0, value_loss = 0, entropy = 0;  // means of minibatches
  double kl = 0;  // mean of KL(old || new) after the last step
  double clip_fraction = 0;
  double latent_kl = 0;  // mean of minibatches; 0: the policy has no latent
  double gradient_norm[kNumNetworks] = {0, 0};  // means, before clipping
  int64_t non_finite = 0;                       // minibatches skipped
  double flops = 0;
};

// The passes of one iteration over a finished batch:
//
//   for each epoch: shuffle the rows, cut them into minibatches; for each:
//     (network, shard) gradients on the ranks
//     from the second epoch on, at the first minibatch: if the mean KL of its
//       rows exceeds kl_stop, stop here, before its step
//     if a loss is not finite: skip it and count
//     per network on the ranks: sum the shards' gradients in order, clip their
//       norm, one step (a norm that is not finite: no step, counted)
//   if not stopped: the KL of a minibatch of rows, drawn as the next epoch
//     would
//
// While the policy does not learn all of this is done for the value network
// alone, and the policy's figures are 0.
//
// So the KL stop costs nothing until it strikes, and looks at rows drawn at
// random, with all steps of the epoch behind them. KL and clip fraction are
// means over the rows in which the policy acted (Batch::acted). Every number is
// a function of networks, batch and settings; the number of ranks has no part
// in it.
//
// Thread-safety: one caller. Blocking: computes. Errors: those of PpoNetworks;
// the update has then been done in part.
absl::StatusOr<UpdateFigures> RunEpochs(const UpdateSettings& settings,
                                        const Batch& batch,
                                        PpoNetworks& networks, RankPool& pool);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_PPO_PPO_UPDATE_H_
