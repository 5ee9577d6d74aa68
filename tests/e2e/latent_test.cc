// A latent from rewards alone, by the real program: no teacher, no labels.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "absl/time/time.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "tests/testing/training_rig.h"

namespace sinew::tests {
namespace {

using ::sinew::testing::IsOk;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TrainingRig::Arguments Latent(const TrainingRig::Arguments& more = {}) {
  TrainingRig::Arguments arguments = {
      "--set", "task.action.placement=absolute",
      "--set", "network.latent.width=3",
      "--set", "network.latent.encoder_hidden=8",
      "--set", "network.latent.prior_hidden=8",
      "--set", "network.latent.decoder_hidden=8"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

TEST(LatentTest, GoesOnWithTheSameBits) {
  const TrainingRig rig;
  rig.MustRun("straight", rig.Train("straight", 4, Latent()));

  rig.MustRun("half", rig.Train("halves", 2, Latent()));
  rig.MustRun("rest", rig.Train("halves", 4, Latent()));

  EXPECT_EQ(rig.FingerprintOf("halves"), rig.FingerprintOf("straight"));
}

TEST(LatentTest, EndsWithTheSameBitsIfItIsKilled) {
  const TrainingRig rig;
  rig.KillAfter("killed", 2, absl::Milliseconds(7),
                rig.Train("killed", 0, Latent()));
  const int end = rig.Rows("killed") + 2;
  rig.MustRun("rest", rig.Train("killed", end, Latent()));
  rig.MustRun("straight", rig.Train("straight", end, Latent()));

  EXPECT_EQ(rig.FingerprintOf("killed"), rig.FingerprintOf("straight"));
}

TEST(LatentTest, GivesABundleWithTheGraphsOfAStudent) {
  const TrainingRig rig;

  rig.MustRun("run", rig.Train("run", 2, Latent()));

  const std::string folder = JoinPath(rig.Path("run"), "bundle");
  const auto bundle = bundle::ReadBundle(folder);
  ASSERT_THAT(bundle, IsOk());
  EXPECT_EQ(bundle->manifest.latent_width(), 3);
  EXPECT_EQ(bundle->manifest.provenance().sources_size(), 0);
  rig.MustRun("verify", {"verify", folder, "--skip-onnx"});
  const auto metrics = ReadFile(JoinPath(rig.Path("run"), "metrics.jsonl"));
  ASSERT_THAT(metrics, IsOk());
  EXPECT_THAT(*metrics, AllOf(HasSubstr("\"latent_kl\":"),
                              Not(HasSubstr("\"distillation\""))));
  rig.MustRun("again", rig.Train("again", 1, Latent({"--init", folder})));
}

TEST(LatentTest, HasNoComposer) {
  const TrainingRig rig;

  EXPECT_EQ(
      rig.Run("run",
              rig.Train("run", 1,
                        Latent({"--set", "network.composer.primitives=2"})))
          .code,
      kMisused);

  EXPECT_THAT(rig.Output("run"),
              AllOf(HasSubstr("network.composer"),
                    HasSubstr("since network.latent is set")));
}

}  // namespace
}  // namespace sinew::tests
