#ifndef SINEW_DEPLOY_BUNDLE_LATENT_GRAPHS_H_
#define SINEW_DEPLOY_BUNDLE_LATENT_GRAPHS_H_

#include <cstdint>

#include "absl/status/status.h"
#include "deploy/bundle/bundle.h"
#include "proto/sinew/v1/graph.pb.h"

namespace sinew::bundle {

// The four graphs that a bundle with a latent has beside "policy"
// (common/policy/latent_graphs.h), with the ports by which its users speak to
// them:
//
//   "encoder"  input "observation"                     taps "mean", "std"
//   "prior"    input "self_observation"                taps "mean", "std"
//   "decoder"  inputs "self_observation", "latent"     tap "action", executed
//   "sample"   inputs "self_observation", "noise"      tap "action", executed
//
// Thread-safety: pure functions. Blocking: never.

// Width of the input "latent" of the graph "decoder"; 0 if there is none.
int64_t LatentWidth(const v1::PolicyGraph& graph);

// Whether graphs or manifest speak of one.
bool HasLatent(const Bundle& bundle);

// Of a bundle whose graphs are valid (policy::ValidateGraph) and whose manifest
// has the widths of its layout: that it has all of the four graphs or none,
// with these widths, and an action law that needs no reference.
// INVALID_ARGUMENT names file, graph, port or field, expected and found.
absl::Status CheckLatent(const Bundle& bundle);

}  // namespace sinew::bundle

#endif  // SINEW_DEPLOY_BUNDLE_LATENT_GRAPHS_H_
