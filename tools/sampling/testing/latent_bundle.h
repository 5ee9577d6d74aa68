#ifndef SINEW_TOOLS_SAMPLING_TESTING_LATENT_BUNDLE_H_
#define SINEW_TOOLS_SAMPLING_TESTING_LATENT_BUNDLE_H_

#include <string>

#include "deploy/bundle/bundle.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::sampling::testing {

// Functions abort with a message on any error.

// Width of the latent below, and of the toy's own state (SELF_JOINT_SPACE).
inline constexpr int kToyLatent = 3;
inline constexpr int kToySelf = 33;

// The toy world whose targets are placed around the default pose, as those of
// a policy with a latent are.
world::testing::ToyWorld MakeLatentToy();

// A bundle for it: the toy's "policy" and, of single linear layers with small
// random weights, "encoder", "prior", "decoder" and "sample" with inputs and
// taps as common/policy/latent_builder.h names them. The prior's spread is 1.
bundle::BundleContent LatentContent(const world::testing::ToyWorld& toy);

// Written into the toy's folder; returns where.
std::string WriteLatentBundle(const world::testing::ToyWorld& toy);

}  // namespace sinew::sampling::testing

#endif  // SINEW_TOOLS_SAMPLING_TESTING_LATENT_BUNDLE_H_
