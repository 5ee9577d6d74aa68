#ifndef SINEW_LEARNER_DISTILLATION_DISTILLATION_LEARNER_H_
#define SINEW_LEARNER_DISTILLATION_DISTILLATION_LEARNER_H_

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/policy/safetensors.h"
#include "common/segment/mirror.h"
#include "learner/learner.h"
#include "proto/sinew/v1/graph.pb.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "teacher/client/annotator.h"

namespace sinew::learner {

// A student that learns what a teacher would do in the states that it visits
// itself: Recipe.distillation, through a latent (network.latent) or without.
//
//   Prepare   labels of all valid rows (labeller.h), the segments' rows
//             together with them as chunks; the state does not change
//   Update    statistics of the new rows (NormaliserRows, labels.h), and of
//             their mirror images with distillation.mirror, into the
//             normaliser, which minibatches and the next snapshot use alike
//             chunks into the memory (learner/memory), in order of order_id
//             the minibatches that are due (distillation_update.h), with the
//             KL's weight by the rows inserted before this update
//
// Rows of episodes in which teacher or prior act (distillation.teacher_share,
// prior_share) are learnt from like others and count in samples, reward and
// distances; those of the prior do not count in the normaliser.
//
// Gradients are summed over `distillation.shards` in fixed order whatever the
// number of ranks (threads), so the result is a pure function of (state,
// segments, recipe, teacher).
//
// graph() has, with a latent, the graphs of common/policy/latent_builder.h;
// else "policy" without exploration (training_graph.h). In both the actor's
// executed tap has no noise but the latent's. Of the counters in a state it
// owns policy_optimiser_step, normaliser_count and memory.
//
// Thread-safety: one caller. Ownership: owns networks, memory and `ranks`
// threads; borrows the annotator. Blocking: Update computes for up to seconds;
// Prepare waits for the annotator, whose calls have deadlines. Errors:
// INVALID_ARGUMENT for segments or weights that do not fit, what the annotator
// says, INTERNAL for labels that are not finite: nothing has changed then.
// DATA_LOSS at Load for chunks that are damaged; a Load that fails has changed
// nothing.
class DistillationLearner : public Learner {
 public:
  struct Options {
    int observation_width = 0;
    // Leading columns of the observation that prior and decoder see; with a
    // latent.
    int self_observation_width = 0;
    int action_width = 0;
    int ranks = 1;  // threads, >= 1
    teacher::Annotator* annotator = nullptr;
    // Of the task (common/segment/segment_layout.h).
    v1::SegmentLayout layout = {};
    // The student's action law, per joint: radians per unit of action.
    std::vector<double> action_scale = {};
    // Of the task; needed if the recipe says distillation.mirror.
    std::optional<SegmentMirror> mirror = std::nullopt;
    // Adds frozen graphs that actors need beside the policy, with their
    // weights (the teacher that acts in a share of episodes); may be empty.
    std::function<absl::Status(v1::PolicyGraph&, TensorMap&)> add_graphs = {};
  };
  // INVALID_ARGUMENT names what does not fit: the recipe, widths, the teacher's
  // widths, layout or scales. FAILED_PRECONDITION for "cuda" without a
  // device and for bfloat16 on a CPU without it.
  static absl::StatusOr<std::unique_ptr<DistillationLearner>> Create(
      const v1::Recipe& recipe, const Options& options);
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_DISTILLATION_DISTILLATION_LEARNER_H_
