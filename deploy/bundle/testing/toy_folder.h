#ifndef SINEW_DEPLOY_BUNDLE_TESTING_TOY_FOLDER_H_
#define SINEW_DEPLOY_BUNDLE_TESTING_TOY_FOLDER_H_

#include <string>
#include <vector>

#include "sim/world/testing/toy_world.h"

namespace sinew::bundle::testing {

// Folders of toy bundles, for tests of what is read and written there. Aborts
// with a message, or fails the test, on any error.

// The toy world of a test program, made once.
const world::testing::ToyWorld& Toy();

// Writes ToyContent(Toy()) into a folder of the running test's own, anew, and
// returns its path.
std::string WriteToy(const std::string& name = "toy");

// Paths of all files below a folder, relative to it.
std::vector<std::string> FilesOf(const std::string& directory);

}  // namespace sinew::bundle::testing

#endif  // SINEW_DEPLOY_BUNDLE_TESTING_TOY_FOLDER_H_
