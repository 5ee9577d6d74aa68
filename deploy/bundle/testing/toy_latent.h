#ifndef SINEW_DEPLOY_BUNDLE_TESTING_TOY_LATENT_H_
#define SINEW_DEPLOY_BUNDLE_TESTING_TOY_LATENT_H_

#include <cstdint>
#include <string>

#include "common/policy/safetensors.h"
#include "deploy/bundle/bundle.h"
#include "proto/sinew/v1/graph.pb.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/snapshot.pb.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::bundle::testing {

// Untrained policies with a latent (common/policy/latent_builder.h), for tests:
// one narrow hidden layer per network, and weights in which every parameter
// matters. Functions abort with a message on any error.
struct LatentWidths {
  int64_t self = 33;
  int64_t observation = 68;
  int64_t action = 4;
  int64_t latent = 6;
};

// Graphs "policy", "encoder", "prior", "decoder", "sample".
v1::PolicyGraph LatentGraphs(const LatentWidths& widths = {});

TensorMap LatentWeights(const LatentWidths& widths = {});

v1::Snapshot LatentSnapshot(const LatentWidths& widths = {});

// The toy's recipe with targets around the current pose.
v1::Recipe ToyLatentRecipe();

// The content of a bundle for the toy world of such a recipe.
BundleContent ToyLatentContent(const world::testing::ToyWorld& toy,
                               const LatentWidths& widths = {});

// The same, written into the toy's folder; returns where.
std::string WriteToyLatent(const world::testing::ToyWorld& toy,
                           const LatentWidths& widths = {});

}  // namespace sinew::bundle::testing

#endif  // SINEW_DEPLOY_BUNDLE_TESTING_TOY_LATENT_H_
