#ifndef SINEW_LEARNER_LEARNER_H_
#define SINEW_LEARNER_LEARNER_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "common/policy/safetensors.h"
#include "proto/sinew/v1/graph.pb.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "proto/sinew/v1/training_state.pb.h"

namespace sinew::learner {

// Figures of one distillation update; names as in metrics.jsonl.
struct DistillationFigures {
  double action_loss = 0;       // as the form has it
  double action_error_rad = 0;  // root mean square of target errors
  double latent_kl = 0;         // KL(posterior || prior), nats, summed over z
  double continuity_loss = 0;
  double kl_weight = 0;
  int64_t memory_rows = 0;  // after inserting
  int64_t labelled_rows = 0;
};

// Figures of one update; names as in metrics.jsonl. What an algorithm does not
// have stays 0.
struct UpdateStatistics {
  int64_t samples = 0;  // valid rows used
  int32_t epochs = 0;   // passes done before the KL stop
  double policy_loss = 0, value_loss = 0, entropy = 0;
  double kl = 0;  // mean KL(old || new) after the last pass
  double clip_fraction = 0;
  double policy_gradient_norm = 0, value_gradient_norm = 0;  // mean, unclipped
  double explained_variance = 0;
  double reward_mean = 0;
  std::vector<double> reward_terms;  // means
  double body_distance_mean_m = 0;
  double policy_learning_rate = 0, value_learning_rate = 0, std_factor = 1;
  int64_t non_finite = 0;  // minibatches skipped for non-finite loss
  double flops = 0;        // multiply-adds * 2 of the update, computed
  // Mean KL(posterior || prior), nats, summed over z; of PPO with a latent.
  std::optional<double> latent_kl;
  std::optional<DistillationFigures> distillation;
};

// A piece of the learning state that is too large to be written anew at every
// save: immutable, named by its digest.
struct StateChunk {
  std::string sha256;  // of bytes, hex
  std::shared_ptr<const std::string> bytes;
};

// What learns from segments: PPO (ppo/ppo_learner.h) or distillation
// (distillation/distillation_learner.h). The trainer knows no more of it.
//
// The result of Update is a pure function of (state, segments, recipe),
// whatever the number of threads.
//
// Thread-safety: one caller. Ownership: owns its networks and threads.
// Blocking: Update computes for up to seconds; Prepare (or Update) waits for
// what it needs (labels) with a deadline. Errors: INVALID_ARGUMENT for segments
// or weights that do not fit; what labelling failed with; nothing has changed
// then.
class Learner {
 public:
  virtual ~Learner() = default;

  // Asks others for what Update of these segments will need (labels); Update
  // does it by itself where nobody has; the same segments. The state does not
  // change, whether it fails or not, so that a caller may save it then.
  virtual absl::Status Prepare(
      absl::Span<const v1::Segment* const> /*segments*/) {
    return absl::OkStatus();
  }
  // One iteration over the segments of all orders, sorted by order_id.
  virtual absl::StatusOr<UpdateStatistics> Update(
      absl::Span<const v1::Segment* const> segments, int64_t iteration) = 0;

  // Graph "policy" and whatever belongs to the bundle beside it; "critic" stays
  // here.
  virtual const v1::PolicyGraph& graph() const = 0;
  // Current weights, normaliser included (float32).
  virtual TensorMap weights() const = 0;

  // Whole learning state: weights, Adam moments, normaliser sums (float64),
  // and counters in `state` (fields the learner owns). Load then Update gives
  // the same bits as never having stopped. Load takes the chunks that the
  // counters name.
  virtual TensorMap SaveTensors() const = 0;
  virtual void SaveCounters(v1::TrainingState& state) const = 0;
  virtual std::vector<StateChunk> SaveChunks() const { return {}; }
  virtual absl::Status Load(const TensorMap& tensors,
                            const v1::TrainingState& state,
                            absl::Span<const StateChunk> chunks) = 0;
  // Weights only (--init BUNDLE): parameters of equal name and of equal or
  // narrower shape (update/widening.h), the policy's all of them.
  virtual absl::Status InitFrom(const TensorMap& weights) = 0;

  // Annealing: factors on std and learning rates, in effect from the next
  // snapshot / update on.
  virtual void SetFactors(double std_factor, double learning_rate_factor) = 0;
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_LEARNER_H_
