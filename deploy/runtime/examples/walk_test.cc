// The example runs: with an untrained policy, which adds little to a reference
// that stands by itself.
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

Outcome Walk(const std::vector<std::string>& arguments) {
  std::vector<std::string> argv = {
      testing::Runfile("sinew/deploy/runtime/examples/walk")};
  argv.insert(argv.end(), arguments.begin(), arguments.end());
  return testing::RunProgram(argv);
}

TEST(Walk, StepsABundleAndSaysHowFarItWent) {
  const world::testing::ToyWorld toy = world::testing::MakeToyWorld();
  const std::string bundle = JoinPath(toy.folder, "bundle");
  ASSERT_THAT(bundle::WriteBundle(
                  bundle::testing::ToyContent(toy, /*gain=*/0.01), bundle),
              IsOk());

  const Outcome outcome = Walk({bundle, JoinPath(toy.folder, "library"), "2"});

  EXPECT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_THAT(outcome.output,
              ContainsRegex("turn: walked [0-9.]+ m in 2.0 s, root at 0.4"));
}

TEST(Walk, SaysWhatIsWrongWithABundle) {
  const Outcome outcome = Walk({"/nowhere", "/nowhere"});

  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.output, HasSubstr("/nowhere: expected a bundle"));
}

}  // namespace
}  // namespace sinew::runtime
