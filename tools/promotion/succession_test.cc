#include "tools/promotion/succession.h"

#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr auto kUnfit = absl::StatusCode::kFailedPrecondition;

v1::BundleManifest Plain() {
  v1::BundleManifest manifest;
  manifest.add_graphs("policy");
  manifest.mutable_physics()->set_physics_hz(120);
  return manifest;
}

v1::BundleManifest WithLatent() {
  v1::BundleManifest manifest = Plain();
  for (const char* name : {"encoder", "prior", "decoder", "sample"}) {
    manifest.add_graphs(name);
  }
  manifest.set_self_observation_width(33);
  manifest.set_latent_width(6);
  return manifest;
}

TEST(Succession, MayAddALatent) {
  EXPECT_THAT(CheckSuccession(Plain(), WithLatent()), IsOk());
  EXPECT_THAT(CheckSuccession(WithLatent(), WithLatent()), IsOk());
}

TEST(Succession, NamesTheGraphThatIsLost) {
  EXPECT_THAT(
      CheckSuccession(WithLatent(), Plain()),
      StatusIs(kUnfit, HasSubstr("graphs: expected \"encoder\", which the "
                                 "incumbent has, found policy")));
}

TEST(Succession, NamesTheWidthThatDiffers) {
  v1::BundleManifest narrow = WithLatent(), blind = WithLatent();
  narrow.set_latent_width(5);
  blind.set_self_observation_width(31);

  EXPECT_THAT(
      CheckSuccession(WithLatent(), narrow),
      StatusIs(kUnfit, HasSubstr("latent_width: expected the incumbent's 6, "
                                 "found 5")));
  EXPECT_THAT(CheckSuccession(WithLatent(), blind),
              StatusIs(kUnfit, HasSubstr("self_observation_width: expected the "
                                         "incumbent's 33, found 31")));
}

TEST(Succession, IsInTheSameWorld) {
  v1::BundleManifest fine = Plain(), weak = Plain(), shaken = Plain();
  fine.mutable_physics()->set_physics_hz(240);
  weak.mutable_task()
      ->mutable_actuator_model()
      ->add_drives()
      ->set_static_friction(0.5);
  shaken.mutable_task()->mutable_randomisation()->set_mass(0.1);
  // A candidate may have been trained so.
  EXPECT_THAT(CheckSuccession(Plain(), shaken), IsOk());
  shaken.mutable_task()->mutable_randomisation()->set_in_evaluation(true);

  EXPECT_THAT(
      CheckSuccession(Plain(), fine),
      StatusIs(kUnfit, AllOf(HasSubstr("physics: expected the incumbent's"),
                             HasSubstr("physics_hz: 120 -> 240"))));
  EXPECT_THAT(CheckSuccession(Plain(), weak),
              StatusIs(kUnfit, HasSubstr("task.actuator_model: expected")));
  EXPECT_THAT(CheckSuccession(Plain(), shaken),
              StatusIs(kUnfit, HasSubstr("task.randomisation: expected")));
  EXPECT_THAT(CheckSuccession(shaken, shaken), IsOk());
}

}  // namespace
}  // namespace sinew::tools
