// The example runs: with an untrained policy, which adds little to a reference
// that stands by itself.
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "common/files.h"
#include "common/subprocess.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::runtime {
namespace {

using ::sinew::testing::IsOk;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;

struct Outcome {
  int code = -1;
  std::string output;
};

Outcome Walk(const std::vector<std::string>& arguments) {
  const std::string log = JoinPath(std::getenv("TEST_TMPDIR"), "walk.txt");
  EXPECT_THAT(RemoveRecursively(log), IsOk());
  std::vector<std::string> argv = {absl::StrCat(
      std::getenv("TEST_SRCDIR"), "/sinew/deploy/runtime/examples/walk")};
  argv.insert(argv.end(), arguments.begin(), arguments.end());
  auto child = Subprocess::Start({.argv = argv, .output_file = log});
  EXPECT_THAT(child, IsOk());
  const auto status = (*child)->Wait(absl::Minutes(1));
  EXPECT_THAT(status, IsOk());
  return {.code = status->code, .output = *ReadFile(log)};
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
