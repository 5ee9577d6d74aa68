#ifndef SINEW_LEARNER_DISTILLATION_DISTILLATION_NETWORKS_H_
#define SINEW_LEARNER_DISTILLATION_DISTILLATION_NETWORKS_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "common/policy/safetensors.h"
#include "proto/sinew/v1/distillation.pb.h"
#include "proto/sinew/v1/graph.pb.h"

namespace sinew::learner {

// The tensor half of distillation, with libtorch behind it: the student's
// networks, their optimiser and one minibatch, which is cut into shards of
// whole sequences. Calls go, per minibatch,
//
//   Gradient(shard)    any thread, different shards
//   SumGradients, Step alone
//
// Losses: distillation_loss.h. The graph that is differentiated:
// training_graph.h. Observations are normalised with today's statistics.
//
// Thread-safety: as above. Each thread has called UseOneThread. Ownership: owns
//   all tensors. Blocking: computes. Errors: INVALID_ARGUMENT at Create and
//   Load, FAILED_PRECONDITION at Create for bfloat16 on a CPU without it;
//   INTERNAL with libtorch's message else. Non-finite numbers pass
//   through: the caller looks at losses and norms.
class DistillationNetworks {
 public:
  struct Options {
    std::string device = "cpu";  // or "cuda"
    int shards = 1;
    int64_t shard_rows = 1;  // whole sequences
    int64_t steps = 1;       // of a sequence
    v1::Distillation::Form form = v1::Distillation::FORM_CODE;
    bool bfloat16 = false;             // products, outputs and gradients
    std::vector<double> action_scale;  // [A] rad per unit of action
  };

  // n = shard_rows rows. Borrowed for the call.
  struct Rows {
    absl::Span<const float> observation;  // [n, O], not normalised
    absl::Span<const float> noise;        // [n, Z]; empty without a latent
    absl::Span<const float> label;        // [n, A]
    absl::Span<const float> valid;        // [n]
    absl::Span<const float> linked;       // [n]
  };
  struct Weights {
    double kl = 0;
    double continuity = 0;
    double row_scale = 0;   // 1 / valid rows of the minibatch
    double pair_scale = 0;  // 1 / linked rows of it
  };
  // A shard's parts of the minibatch's figures, which are their sums.
  struct Figures {
    double loss = 0;
    double action = 0, latent_kl = 0, continuity = 0;  // not weighed
    double squared_error_rad2 = 0;  // sum over valid rows and joints
    // Mean over the valid rows of each sequence of its part of the action loss.
    std::vector<float> sequence_loss;
  };

  // `graph`: with a latent (common/policy/latent_builder.h) or without.
  static absl::StatusOr<std::unique_ptr<DistillationNetworks>> Create(
      const v1::PolicyGraph& graph, const TensorMap& weights,
      const Options& options);
  virtual ~DistillationNetworks() = default;

  virtual int64_t latent_width() const = 0;  // Z; 0: no latent

  // Gradient of the loss into this shard's buffer.
  virtual absl::StatusOr<Figures> Gradient(int shard, const Rows& rows,
                                           const Weights& weights) = 0;
  // Sums the shards' gradients in order; their Euclidean norm.
  virtual absl::StatusOr<double> SumGradients() = 0;
  // One step of Adam (0.9, 0.999, 1e-8) along the summed gradient times
  // `gradient_scale`.
  virtual absl::Status Step(double learning_rate, double gradient_scale) = 0;
  // The gradient that SumGradients left, by parameter's name. For tests.
  virtual TensorMap gradient() const = 0;

  // Floating-point operations of a minibatch's row.
  virtual double flops_per_row() const = 0;

  // All parameters of the graph by name; Load wants all of them.
  virtual absl::Status LoadWeights(const TensorMap& weights) = 0;
  virtual TensorMap SaveWeights() const = 0;
  // Adam: "adam/first_moment/NAME", "adam/second_moment/NAME" and steps.
  virtual absl::Status LoadOptimiser(const TensorMap& tensors,
                                     int64_t steps) = 0;
  virtual void SaveOptimiser(TensorMap& tensors) const = 0;
  virtual int64_t optimiser_steps() const = 0;
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_DISTILLATION_DISTILLATION_NETWORKS_H_
