#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "common/config/nearest_name.h"
#include "common/config/recipe.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew {
namespace {

using ::sinew::testing::EqualsProto;
using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;

// An empty recipe after one assignment that must succeed.
v1::Recipe After(absl::string_view assignment) {
  v1::Recipe recipe;
  EXPECT_THAT(SetRecipeField(recipe, assignment), IsOk()) << assignment;
  return recipe;
}

absl::Status Try(absl::string_view assignment) {
  v1::Recipe recipe;
  return SetRecipeField(recipe, assignment);
}

TEST(SetRecipeField, SetsValuesOfEveryType) {
  EXPECT_THAT(After("ppo.epochs=3"), EqualsProto("ppo { epochs: 3 }"));
  EXPECT_THAT(After("rollouts.replay_bytes=5000000000"),
              EqualsProto("rollouts { replay_bytes: 5000000000 }"));
  EXPECT_THAT(After("seed=18446744073709551615"),
              EqualsProto("seed: 18446744073709551615"));
  EXPECT_THAT(After("ppo.policy_learning_rate=1e-3"),
              EqualsProto("ppo { policy_learning_rate: 0.001 }"));
  EXPECT_THAT(After("task.action.ramp=true"),
              EqualsProto("task { action { ramp: true } }"));
  EXPECT_THAT(After("device=cuda"), EqualsProto("device: 'cuda'"));
  EXPECT_THAT(After("device=\"a=b\""), EqualsProto("device: 'a=b'"));
}

TEST(SetRecipeField, TakesEnumsWithAndWithoutTheirPrefix) {
  for (const char* value : {"bins", "BINS", "rule_bins", "RULE_BINS"}) {
    EXPECT_THAT(After(std::string("task.start.rule=") + value),
                EqualsProto("task { start { rule: RULE_BINS } }"));
  }
}

TEST(SetRecipeField, ReplacesLists) {
  v1::Recipe recipe = After("network.policy_hidden=[1, 2, 3]");

  ASSERT_THAT(SetRecipeField(recipe, " network.policy_hidden = [512,256] "),
              IsOk());

  EXPECT_THAT(recipe,
              EqualsProto("network { policy_hidden: 512 policy_hidden: 256 }"));
  EXPECT_THAT(After("network.policy_hidden=64"),
              EqualsProto("network { policy_hidden: 64 }"));
  EXPECT_THAT(After("network.policy_hidden=[]"), EqualsProto("network {}"));
  EXPECT_THAT(After("task.observation.blocks=[self_contact, "
                    "BLOCK_PREVIOUS_TARGET]"),
              EqualsProto("task { observation { blocks: BLOCK_SELF_CONTACT "
                          "blocks: BLOCK_PREVIOUS_TARGET } }"));
}

TEST(SetRecipeField, SetsWhatTrainingsInStagesAreMadeOf) {
  EXPECT_THAT(After("task.start.only_clips=[walk, run_2]"),
              EqualsProto("task { start { only_clips: 'walk' "
                          "only_clips: 'run_2' } }"));
  EXPECT_THAT(After("plateau.gain=0"), EqualsProto("plateau { gain: 0 }"));
  EXPECT_THAT(After("plateau.min_samples=5000000000"),
              EqualsProto("plateau { min_samples: 5000000000 }"));
  EXPECT_THAT(After("procedure.composer_hidden=[512,256]"),
              EqualsProto("procedure { composer_hidden: 512 "
                          "composer_hidden: 256 }"));
  EXPECT_THAT(After("network.composer.primitives=3"),
              EqualsProto("network { composer { primitives: 3 } }"));
}

TEST(SetRecipeField, KeepsAZeroThatHasAMeaning) {
  EXPECT_THAT(After("ppo.gae_lambda=0"), EqualsProto("ppo { gae_lambda: 0 }"));
  EXPECT_EQ(WithDefaults(After("ppo.gae_lambda=0")).ppo().gae_lambda(), 0);
}

TEST(SetRecipeField, NamesAnUnknownFieldAndTheNearest) {
  EXPECT_THAT(
      Try("ppo.epoch=3"),
      StatusIs(absl::StatusCode::kInvalidArgument,
               AllOf(HasSubstr("--set ppo.epoch: no recipe field \"epoch\"; "
                               "the nearest is \"epochs\" of discount, "),
                     HasSubstr("minibatch"))));
  EXPECT_THAT(Try("pp.epochs=3"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("the nearest is \"ppo\"")));
  EXPECT_THAT(Try("ppo..epochs=3"),
              StatusIs(absl::StatusCode::kInvalidArgument));
}

TEST(SetRecipeField, NamesTheValueThatDoesNotFit) {
  EXPECT_THAT(Try("ppo.epochs=many"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "--set ppo.epochs: expected a value of type int32, "
                       "found \"many\""));
  EXPECT_THAT(Try("ppo.epochs=3 minibatch: 5"),
              StatusIs(absl::StatusCode::kInvalidArgument));
  EXPECT_THAT(Try("ppo.epochs=3000000000"),
              StatusIs(absl::StatusCode::kInvalidArgument));
  EXPECT_THAT(Try("ppo.epochs="), StatusIs(absl::StatusCode::kInvalidArgument));
  EXPECT_THAT(
      Try("network.policy_hidden=[1,,2]"),
      StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("found \"\"")));
  EXPECT_THAT(Try("task.start.rule=newest"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "--set task.start.rule: expected one of RULE_UNIFORM, "
                       "RULE_BINS, RULE_PHC_SOFT, RULE_PHC_HARD, "
                       "RULE_ADAPTIVE_BINS, found \"newest\""));
}

TEST(SetRecipeField, NeedsAValueInsideAGroup) {
  EXPECT_THAT(Try("ppo.anneal=3"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("expected a field inside the group, one of "
                                 "success_share")));
  EXPECT_THAT(Try("seed.low=3"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("seed is a value and has no field low")));
  EXPECT_THAT(Try("seed"), StatusIs(absl::StatusCode::kInvalidArgument,
                                    "--set: expected path=value, found "
                                    "\"seed\""));
}

TEST(SetRecipeField, LeavesTheRecipeAsItWasOnFailure) {
  v1::Recipe recipe = After("network.policy_hidden=[1,2]");

  EXPECT_FALSE(SetRecipeField(recipe, "network.policy_hidden=[3,x]").ok());
  EXPECT_FALSE(SetRecipeField(recipe, "ppo.anneal.nothing=1").ok());

  EXPECT_THAT(recipe,
              EqualsProto("network { policy_hidden: 1 policy_hidden: 2 }"));
}

TEST(NearestName, CountsLettersThatDiffer) {
  EXPECT_EQ(NearestName("epoch", {"shards", "epochs", "anneal"}), "epochs");
  EXPECT_EQ(NearestName("minibach", {"minibatch", "mini"}), "minibatch");
  EXPECT_EQ(NearestName("x", {"ab", "y"}), "y");
  EXPECT_EQ(NearestName("x", {}), "");
}

}  // namespace
}  // namespace sinew
