#ifndef SINEW_ACTOR_PREPARED_SNAPSHOT_H_
#define SINEW_ACTOR_PREPARED_SNAPSHOT_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "actor/rollout_assets.h"
#include "common/policy/executor.h"
#include "proto/sinew/v1/snapshot.pb.h"
#include "sim/world/start.h"

namespace sinew::actor {

// How a rollout talks to a graph that acts: names of its inputs and taps.
struct PolicyPorts {
  std::string observation;         // the data input, width O or S
  std::vector<std::string> noise;  // normal inputs, in graph order
  std::string action;              // the executed tap, width A
  std::string mean;                // tap of the action's mean, width A
  std::string std_parameter;       // [A]; empty: no distribution
  std::string latent_noise;        // the tap that records it; empty: none
};

// A graph that acts, with its weights.
struct ActingGraph {
  PolicyPorts ports;
  std::shared_ptr<const policy::WeightsPack> pack;
  int action_width = 0;
  int latent_noise_width = 0;  // 0: none is recorded
  // Standard deviation of the action, [A], > 0; empty: no distribution.
  std::vector<double> std;
};

// A snapshot made ready to act with: packed weights, start table.
//
// The graph "policy" has exactly one data input, any number of normal inputs,
// and exactly one executed tap. That is Gaussian, and the Gaussian's mean has a
// tap as well: zero noise makes action and mean equal. Or it has no
// distribution, and there is a tap "mean" of the same width: the policy's noise
// is somewhere within (common/policy/latent_builder.h). A tap "latent_noise" is
// what the column of that name records. Graph "teacher" is
// another such graph; it is looked at where the recipe has a teacher_share
// (common/policy/teacher_graph.h). Graph "sample"
// (common/policy/latent_builder.h) sees the body's own state alone, and its
// action is its own mean; it is looked at where the recipe has a prior_share.
// Other graphs are ignored.
//
// Thread-safety: immutable; shared between workers. Ownership: copies what it
// needs of the snapshot. Blocking: Create computes (checks, packing). Errors:
// INVALID_ARGUMENT names what does not fit: graph, tap, widths, a non-finite
// weight, a standard deviation that is not positive, a curriculum bin.
class PreparedSnapshot {
 public:
  // `sha256` is the digest under which the snapshot was fetched.
  static absl::StatusOr<std::shared_ptr<const PreparedSnapshot>> Create(
      const v1::Snapshot& snapshot, const std::string& sha256,
      const RolloutAssets& assets);

  int64_t version() const { return version_; }
  const std::string& sha256() const { return sha256_; }
  const world::StartTable& starts() const { return starts_; }
  const ActingGraph& policy() const { return policy_; }
  // Null: there is none, or the recipe has no use for it.
  const ActingGraph* teacher() const {
    return teacher_.has_value() ? &*teacher_ : nullptr;
  }
  const ActingGraph* prior() const {
    return prior_.has_value() ? &*prior_ : nullptr;
  }

 private:
  PreparedSnapshot(world::StartTable starts) : starts_(std::move(starts)) {}

  int64_t version_ = 0;
  std::string sha256_;
  world::StartTable starts_;
  ActingGraph policy_;
  std::optional<ActingGraph> teacher_, prior_;
};

}  // namespace sinew::actor

#endif  // SINEW_ACTOR_PREPARED_SNAPSHOT_H_
