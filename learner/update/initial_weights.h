#ifndef SINEW_LEARNER_UPDATE_INITIAL_WEIGHTS_H_
#define SINEW_LEARNER_UPDATE_INITIAL_WEIGHTS_H_

#include <string>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "common/policy/safetensors.h"
#include "proto/sinew/v1/graph.pb.h"

namespace sinew::learner {

// Weights that training begins with and that others have learned. Names of
// parameters: common/policy/builder.h. Critics may be missing anywhere, and the
// standard deviation of exploration is never taken: it is the recipe's.
//
// Pure functions: thread-safe, never blocking. INVALID_ARGUMENT names source
// and tensor, expected and found shape; `into` is then as it was.

// A trained policy of one network that a composer is to weigh.
struct Primitive {
  std::string name;  // in errors, e.g. its bundle's folder
  TensorMap weights;
};

// Copies what `into`, the parameters of `graph`, has under the same name;
// hidden layers of `from` may be narrower (widening.h), so that a network grows
// without another function. `from` must have all that the graph "policy" reads
// but for exploration's standard deviation, which a student's bundle has none
// of.
absl::Status TakeWeights(const v1::PolicyGraph& graph, const TensorMap& from,
                         TensorMap& into);

// Copies primitive k, layers and normaliser, to where the composer `into` of so
// many primitives has it, and the first one's normaliser to the composer's own:
// it sees the same observations. Layers that the composer's primitives lack are
// an error, as is a primitive that is a composer itself.
absl::Status TakePrimitives(absl::Span<const Primitive> primitives,
                            TensorMap& into);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_UPDATE_INITIAL_WEIGHTS_H_
