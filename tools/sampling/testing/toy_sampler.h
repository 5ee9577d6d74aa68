#ifndef SINEW_TOOLS_SAMPLING_TESTING_TOY_SAMPLER_H_
#define SINEW_TOOLS_SAMPLING_TESTING_TOY_SAMPLER_H_

#include <memory>

#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_latent.h"
#include "sim/world/testing/toy_world.h"
#include "tools/sampling/sampler.h"

namespace sinew::sampling::testing {

// A toy world, a bundle with a latent for it, and the bundle's sampler. Throws
// on any error.
struct ToySampler {
  world::testing::ToyWorld world =
      world::testing::MakeToyWorld(bundle::testing::ToyLatentRecipe());
  bundle::Bundle bundle =
      bundle::ReadBundle(bundle::testing::WriteToyLatent(world)).value();
  std::unique_ptr<const Sampler> sampler = Sampler::Create(bundle).value();
};

}  // namespace sinew::sampling::testing

#endif  // SINEW_TOOLS_SAMPLING_TESTING_TOY_SAMPLER_H_
