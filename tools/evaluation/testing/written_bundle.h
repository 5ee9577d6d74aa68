#ifndef SINEW_TOOLS_EVALUATION_TESTING_WRITTEN_BUNDLE_H_
#define SINEW_TOOLS_EVALUATION_TESTING_WRITTEN_BUNDLE_H_

#include <gtest/gtest.h>

#include <string>

#include "common/files.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::evaluation::testing {

// A bundle of a random policy, and the library it was made for, on disk.
class WrittenBundle : public ::testing::Test {
 protected:
  void Write(
      const v1::Recipe& recipe = world::testing::ToyRecipe(),
      world::testing::ToyClips clips = world::testing::ToyClips::kStanding) {
    const world::testing::ToyWorld toy =
        world::testing::MakeToyWorld(recipe, clips);
    bundle_ = JoinPath(toy.folder, "bundle");
    motions_ = toy.library_folder;
    out_ = JoinPath(toy.folder, "eval.json");
    ASSERT_THAT(bundle::WriteBundle(bundle::testing::ToyContent(toy), bundle_),
                sinew::testing::IsOk());
  }

  std::string bundle_, motions_;
  std::string out_;  // where an evaluation may go
};

}  // namespace sinew::evaluation::testing

#endif  // SINEW_TOOLS_EVALUATION_TESTING_WRITTEN_BUNDLE_H_
