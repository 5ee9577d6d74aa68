// Runs over primitives: from two bundles to a composer's, by the real program.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "common/files.h"
#include "common/testing/matchers.h"
#include "tests/testing/training_rig.h"

namespace sinew::tests {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TrainingRig::Arguments Composed(const TrainingRig::Arguments& more) {
  TrainingRig::Arguments arguments = {"--set", "network.composer.primitives=2",
                                      "--set", "network.composer.hidden=8"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

TEST(ComposerTest, GoesOnWithoutTheBundlesThatItBeganWith) {
  const TrainingRig rig;
  rig.MustRun("one", rig.Train("one", 2));
  rig.MustRun("two", rig.Train("two", 2, {"--seed", "4"}));
  const std::string one = JoinPath(rig.Path("one"), "bundle");
  const std::string two = JoinPath(rig.Path("two"), "bundle");
  const auto begun = Composed({"--primitives", one, two});
  rig.MustRun("straight", rig.Train("straight", 4, begun));

  rig.MustRun("half", rig.Train("halves", 2, begun));
  ASSERT_THAT(RemoveRecursively(one), sinew::testing::IsOk());
  ASSERT_THAT(RemoveRecursively(two), sinew::testing::IsOk());
  rig.MustRun("rest", rig.Train("halves", 4, Composed({})));

  EXPECT_EQ(rig.FingerprintOf("halves"), rig.FingerprintOf("straight"));
  const std::string bundle = JoinPath(rig.Path("halves"), "bundle");
  rig.MustRun("verify", {"verify", bundle, "--skip-onnx"});
  EXPECT_THAT(rig.Output("verify"), HasSubstr("composer_weights"));
  rig.MustRun("again", rig.Train("again", 1, Composed({"--init", bundle})));
}

TEST(ComposerTest, SaysWhatItLacks) {
  const TrainingRig rig;

  EXPECT_EQ(rig.Run("none", rig.Train("none", 1, Composed({}))).code, 2);

  EXPECT_THAT(rig.Output("none"),
              AllOf(HasSubstr("network.composer"), HasSubstr("--primitives"),
                    HasSubstr("found 0")));
}

}  // namespace
}  // namespace sinew::tests
