#ifndef SINEW_LEARNER_PPO_TESTING_NETWORKS_RIG_H_
#define SINEW_LEARNER_PPO_TESTING_NETWORKS_RIG_H_

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "absl/types/span.h"
#include "common/policy/safetensors.h"
#include "common/random/philox.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "learner/ppo/batch.h"
#include "learner/ppo/ppo_networks.h"
#include "learner/ppo/synthetic_segments.h"
#include "proto/sinew/v1/rollout.pb.h"

namespace sinew::learner {

// What tests of networks share: weights that have moved on from those that
// acted, and the batch that they are asked about.

// Adds noise of that deviation to the parameters that `moves` picks by name.
inline void MoveOn(float deviation,
                   const std::function<bool(const std::string&)>& moves,
                   TensorMap& weights) {
  uint64_t seed = 0;
  for (auto& [name, tensor] : weights) {
    if (!moves(name)) continue;
    std::vector<float> noise(tensor.num_elements());
    FillNormal({.seed = ++seed}, absl::MakeSpan(noise));
    for (size_t i = 0; i < noise.size(); ++i) {
      tensor.mutable_float32()[i] += deviation * noise[i];
    }
  }
}

// As an update begins: columns, observations, values, returns, targets.
inline BatchFigures LoadBatch(const std::vector<v1::Segment>& segments,
                              Batch& batch, PpoNetworks& networks) {
  using sinew::testing::IsOk;
  EXPECT_THAT(batch.Reset(Pointers(segments)), IsOk());
  EXPECT_THAT(networks.Reserve(batch.rows() + batch.bootstrap_rows()), IsOk());
  for (int s = 0; s < batch.num_segments(); ++s) {
    batch.CopyColumns(s);
    for (const Batch::Block& block : batch.Blocks(s)) {
      EXPECT_THAT(networks.LoadObservations(block.first_row, block.observations,
                                            block.latent_noise),
                  IsOk());
    }
  }
  EXPECT_THAT(networks.Values(0, batch.values()), IsOk());
  for (int s = 0; s < batch.num_segments(); ++s) batch.ComputeReturns(s);
  const BatchFigures figures = batch.Finish();
  EXPECT_THAT(networks.SetTargets(batch), IsOk());
  return figures;
}

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_PPO_TESTING_NETWORKS_RIG_H_
