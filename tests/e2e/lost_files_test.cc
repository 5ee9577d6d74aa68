// A run's folder from which something was lost.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "common/files.h"
#include "common/testing/matchers.h"
#include "tests/testing/training_rig.h"

namespace sinew::tests {
namespace {

using ::sinew::testing::IsOk;
using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(LostFiles, ARunWithoutItsStatesKeepsWhatItHas) {
  const TrainingRig rig;
  rig.MustRun("first", rig.Train("run", 3));
  const std::string manifest = rig.Path("run/bundle/manifest.json");
  const std::string before = *ReadFile(manifest);
  ASSERT_THAT(RemoveRecursively(rig.Path("run/checkpoints")), IsOk());

  EXPECT_EQ(rig.Run("second", rig.Train("run", 4)).code, kFailed);

  EXPECT_THAT(rig.Output("second"),
              AllOf(HasSubstr("expected the training state that"),
                    HasSubstr("run/bundle is of, found none in"),
                    HasSubstr("--checkpoint")));
  EXPECT_EQ(rig.Rows("run"), 3);
  EXPECT_EQ(*ReadFile(manifest), before);
}

TEST(LostFiles, ABestBundleStaysWhereItsAliasIsLost) {
  const TrainingRig rig;
  const auto train = [&](int iterations) {
    return rig.Train("run", iterations, {"--set", "evaluation.interval=1"});
  };
  rig.MustRun("first", train(3));
  const std::string manifest = rig.Path("run/bundle_best/manifest.json");
  const std::string before = *ReadFile(manifest);
  ASSERT_THAT(RemoveRecursively(rig.Path("run/checkpoints/aliases/best")),
              IsOk());

  rig.MustRun("second", train(3));

  EXPECT_THAT(rig.Output("second"), HasSubstr("bundle_best stays as it was"));
  EXPECT_EQ(*ReadFile(manifest), before);
}

}  // namespace
}  // namespace sinew::tests
