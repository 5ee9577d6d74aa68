#ifndef SINEW_LEARNER_PPO_PPO_NETWORKS_H_
#define SINEW_LEARNER_PPO_PPO_NETWORKS_H_

#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "common/policy/safetensors.h"
#include "learner/ppo/batch.h"
#include "proto/sinew/v1/graph.pb.h"

namespace sinew::learner {

enum class NetworkId { kPolicy = 0, kValue = 1 };
inline constexpr int kNumNetworks = 2;

// Sums over the valid rows of a shard; `kl` and `clipped` over those in which
// the policy acted (Batch::acted); `loss` is this shard's part of the
// minibatch's mean loss.
struct GradientFigures {
  double loss = 0;
  double kl = 0;         // policy: sum of KL(old || new), acted rows
  double clipped = 0;    // policy: acted rows with |ratio - 1| > clip
  double entropy = 0;    // policy: sum
  double latent_kl = 0;  // policy with a latent: sum of KL(posterior || prior)
};

// Floating-point operations per row of the products, multiply-adds counting 2.
struct NetworkFlops {
  double load = 0;  // of LoadObservations
  double forward = 0;
  double backward = 0;
};

// The tensor half of PPO, with libtorch behind it: the two networks, their
// optimisers and the batch. Calls go
//
//   Reserve                            once per batch
//   LoadObservations, Values           any thread, disjoint rows
//   SetTargets                         alone
//   per minibatch:
//     Gradient(network, shard)         any thread, different (network, shard)
//     SumGradients, Step(network)      any thread, different networks
//
// With observation o, action a, its probability p_old when sampled, advantage
// A (normalised), target R and weight w of each row, s = 1 / (valid rows of
// the minibatch), the mean m of the policy's Gaussian and the value v:
//
//   ratio       = exp(log p(a | m, std) - log p_old), its logarithm within +-20
//   policy loss = -s sum w min(ratio A, clamp(ratio, 1 - c, 1 + c) A)
//                 - entropy_weight s sum w entropy(std)
//   value loss  = s sum w (v - R)^2 / 2
//   KL          = sum over actions ((m - m_old) / std)^2 / 2, at today's std
//
// Where the policy has a latent (graph "prior",
// common/policy/latent_builder.h), m is the mean for the latent's noise of the
// row, as it was when the policy acted: all of the above is given that noise,
// and gradients go through the latent z = mean + std * noise into the encoder
// (reparameterised). To the policy loss comes
//
//   + latent_kl_weight s sum w min(KL(posterior || prior), 1e5)
//
// (learner/torch/latent_loss.h), from which alone the prior learns.
//
// What no trained parameter influences (normaliser and clamp, a composer's
// primitives) is computed once per batch, in LoadObservations: it stays as it
// was then.
//
// Thread-safety: as above. Each thread has called UseOneThread. Ownership:
//   owns all tensors; SetTargets borrows the batch until the next Reserve.
// Blocking: computes. Errors: INVALID_ARGUMENT at Create and Load; INTERNAL
//   with libtorch's message else. Non-finite numbers pass through: the caller
//   looks at losses and norms.
class PpoNetworks {
 public:
  struct Options {
    std::string device = "cpu";  // or "cuda"
    bool bfloat16 = false;
    int shards = 1;
    double ratio_clip = 0.2;
    double entropy_weight = 0;
    double latent_kl_weight = 0;
  };

  // Graphs "policy" (a tap with a Gaussian around its tap "mean", input
  // "observation") and "critic" (tap "value", width 1); they must not share
  // trained parameters.
  static absl::StatusOr<std::unique_ptr<PpoNetworks>> Create(
      const v1::PolicyGraph& graph, const TensorMap& weights,
      const Options& options);
  virtual ~PpoNetworks() = default;

  virtual absl::Status Reserve(int64_t rows) = 0;
  // `latent_noise` is [rows, Z] where the policy has a latent; empty: it is not
  // asked about these rows.
  virtual absl::Status LoadObservations(
      int64_t first_row, absl::Span<const float> observations,
      absl::Span<const float> latent_noise = {}) = 0;
  // Values of consecutive rows.
  virtual absl::Status Values(int64_t first_row, absl::Span<float> values) = 0;
  virtual absl::Status SetTargets(const Batch& batch) = 0;

  // Gradient of the loss over `rows` into this (network, shard)'s buffer.
  virtual absl::StatusOr<GradientFigures> Gradient(
      NetworkId network, int shard, absl::Span<const int64_t> rows,
      double scale) = 0;
  // The policy's figures alone; changes nothing.
  virtual absl::StatusOr<GradientFigures> PolicyFigures(
      absl::Span<const int64_t> rows, double scale) = 0;
  // Sums the shards' gradients in order; their Euclidean norm.
  virtual absl::StatusOr<double> SumGradients(NetworkId network) = 0;
  // One step of Adam (0.9, 0.999, 1e-8) along the summed gradient times
  // `gradient_scale`.
  virtual absl::Status Step(NetworkId network, double learning_rate,
                            double gradient_scale) = 0;

  virtual NetworkFlops flops(NetworkId network) const = 0;

  // All parameters of the graph by name; Load wants all of them.
  virtual absl::Status LoadWeights(const TensorMap& weights) = 0;
  virtual TensorMap SaveWeights() const = 0;
  // Adam: "adam/first_moment/NAME", "adam/second_moment/NAME" and steps.
  virtual absl::Status LoadOptimiser(NetworkId network,
                                     const TensorMap& tensors,
                                     int64_t steps) = 0;
  virtual void SaveOptimiser(NetworkId network, TensorMap& tensors) const = 0;
  virtual int64_t optimiser_steps(NetworkId network) const = 0;
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_PPO_PPO_NETWORKS_H_
