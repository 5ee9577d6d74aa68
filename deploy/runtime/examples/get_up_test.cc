// The example runs: with an untrained policy, on a toy whose get-up rises from
// where it stands.
#include <string>
#include <vector>

#include "common/files.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "deploy/runtime/testing/run_program.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::runtime {
namespace {

using ::sinew::testing::IsOk;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using testing::Outcome;

Outcome GetUp(world::testing::ToyClips clips) {
  const world::testing::ToyWorld toy =
      world::testing::MakeToyWorld(world::testing::ToyRecipe(), clips);
  const std::string bundle = JoinPath(toy.folder, "bundle");
  EXPECT_THAT(bundle::WriteBundle(
                  bundle::testing::ToyContent(toy, /*gain=*/0.01), bundle),
              IsOk());
  return testing::RunProgram(
      {testing::Runfile("sinew/deploy/runtime/examples/get_up"), bundle,
       toy.library_folder, "3"});
}

TEST(GetUp, SaysHowManyFallsEndUpright) {
  const Outcome outcome = GetUp(world::testing::ToyClips::kWithGetUp);

  EXPECT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, ContainsRegex("[0-3] of 3 up after 5.5 s"));
}

TEST(GetUp, NeedsALibraryWithAGetUp) {
  const Outcome outcome = GetUp(world::testing::ToyClips::kStanding);

  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.output, HasSubstr("expected the library to have a "
                                        "get-up"));
}

}  // namespace
}  // namespace sinew::runtime
