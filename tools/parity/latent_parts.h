#ifndef SINEW_TOOLS_PARITY_LATENT_PARTS_H_
#define SINEW_TOOLS_PARITY_LATENT_PARTS_H_

#include <cstdint>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "deploy/bundle/bundle.h"

namespace sinew::tools {

// How far the actions of a bundle with a latent are from those of its parts, as
// ParityDifference has it (bundle_parity.h): the graphs are files of their own,
// and nothing in their format says that they belong together.
//
//   policy = decoder(own, mean of encoder(observation)), without noise
//   sample = decoder(own, mean + std * noise of prior(own))
//
// where `own` are the observation's first columns.
struct LatentParts {
  double policy = 0;
  double sample = 0;
};

// By the executor, on `rows` >= 1 random inputs, a function of bundle and seed.
// The bundle has a latent (bundle::HasLatent) and was read
// (bundle::ReadBundle), so that its graphs have the ports of
// deploy/bundle/latent_graphs.h. Pure; computes for milliseconds. Errors: the
// executor's.
absl::StatusOr<LatentParts> CompareLatentParts(const bundle::Bundle& bundle,
                                               int rows, uint64_t seed);

// INTERNAL naming the graph that is beyond kParityTolerance (bundle_parity.h).
absl::Status CheckLatentParts(const LatentParts& parts);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_PARITY_LATENT_PARTS_H_
