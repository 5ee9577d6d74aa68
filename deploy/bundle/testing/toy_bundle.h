#ifndef SINEW_DEPLOY_BUNDLE_TESTING_TOY_BUNDLE_H_
#define SINEW_DEPLOY_BUNDLE_TESTING_TOY_BUNDLE_H_

#include <string>

#include "deploy/bundle/bundle.h"
#include "deploy/bundle/content.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/snapshot.pb.h"
#include "sim/character/character.h"
#include "sim/motion/library.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::bundle::testing {

// Bundles of untrained policies, for tests: real in everything but skill.
// Functions abort with a message on any error.

// A snapshot with the recipe's policy network, random weights whose last layer
// has gain `gain`.
v1::Snapshot RandomSnapshot(const v1::Recipe& recipe, int64_t observation_width,
                            int64_t action_width, double gain = 0.3);

// What MakeContent needs of the toy world; the snapshot is the caller's.
ContentInputs ToyInputs(const world::testing::ToyWorld& toy);

// The content of a bundle for the toy world with such a snapshot.
BundleContent ToyContent(const world::testing::ToyWorld& toy,
                         double gain = 0.3);

// The content of a bundle for a character of the source tree ("humanoid",
// "g1") with an empty library.
BundleContent CharacterContent(const std::string& character,
                               const v1::Recipe& recipe);

}  // namespace sinew::bundle::testing

#endif  // SINEW_DEPLOY_BUNDLE_TESTING_TOY_BUNDLE_H_
