#ifndef SINEW_LEARNER_UPDATE_GRAPH_NORMALISERS_H_
#define SINEW_LEARNER_UPDATE_GRAPH_NORMALISERS_H_

#include "common/policy/safetensors.h"
#include "learner/update/normaliser.h"

namespace sinew::learner {

// Where the normalisers of a policy's observation are: one
// (common/policy/builder.h), or of own state and goal apart
// (common/policy/latent_builder.h).
//
// Pure functions: thread-safe, never blocking. The weights are those of such a
// policy; widths are CHECKed.

// Writes the statistics of all observation columns into the normalisers of
// `weights`.
void WriteNormalisers(const Moments& moments, TensorMap& weights);
// The inverse: moments of `count` rows; of kInheritedRows where it is 0, as in
// recipes that say no number.
void InheritNormalisers(const TensorMap& weights, double count,
                        Moments& moments);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_UPDATE_GRAPH_NORMALISERS_H_
