#include "common/config/recipe.h"

#include <limits>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "google/protobuf/descriptor.h"
#include "google/protobuf/message.h"
#include "gtest/gtest.h"

namespace sinew {
namespace {

using ::google::protobuf::FieldDescriptor;
using ::google::protobuf::Message;
using ::sinew::testing::EqualsProto;
using ::sinew::testing::IsOk;
using ::sinew::testing::IsOkAndHolds;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

v1::Recipe MakeRecipe(const std::vector<std::string>& assignments = {}) {
  v1::Recipe recipe = WithDefaults(v1::Recipe());
  for (const std::string& assignment : assignments) {
    EXPECT_THAT(SetRecipeField(recipe, assignment), IsOk());
  }
  return recipe;
}

TEST(Recipe, WithDefaultsIsValid) {
  EXPECT_THAT(ValidateRecipe(MakeRecipe()), IsOk());
}

TEST(Recipe, HasTheDefaultsOfItsComments) {
  const v1::Recipe recipe = MakeRecipe();

  EXPECT_EQ(recipe.physics().physics_hz(), 120);
  EXPECT_EQ(recipe.task().action().range_margin(), 1.5);
  EXPECT_EQ(recipe.task().start().uniform_share(), 0.1);
  EXPECT_THAT(recipe.task().reward(),
              EqualsProto("position_weight: 0.5 rotation_weight: 0.3 "
                          "linear_velocity_weight: 0.1 "
                          "angular_velocity_weight: 0.1 position_kernel: 100 "
                          "rotation_kernel: 10 linear_velocity_kernel: 0.1 "
                          "angular_velocity_kernel: 0.1"));
  EXPECT_THAT(
      recipe.task().observation(),
      EqualsProto("blocks: BLOCK_SELF_JOINT_SPACE "
                  "blocks: BLOCK_REFERENCE_DIFFERENCE frames_ahead: 1"));
  EXPECT_THAT(recipe.network().value_hidden(), ElementsAre(256, 256));
  EXPECT_EQ(recipe.evaluation().interval(), 0);
  EXPECT_EQ(recipe.device(), "cpu");
}

TEST(Recipe, FillsTheRuleOfAdaptiveBinsOnlyWhereItIsInForce) {
  v1::Recipe recipe;
  EXPECT_FALSE(WithDefaults(recipe).task().start().has_adaptive());

  recipe.mutable_task()->mutable_start()->set_rule(
      v1::Start::RULE_ADAPTIVE_BINS);
  recipe.mutable_task()->mutable_start()->mutable_adaptive()->set_bin_floor(0);
  recipe = WithDefaults(recipe);

  EXPECT_THAT(recipe.task().start().adaptive(),
              EqualsProto("pre_failure_seconds: 1 half_life_passages: 30 "
                          "bin_floor: 0 clip_floor: 0.1 clip_cap: 0.25"));
  EXPECT_THAT(ValidateRecipe(recipe), IsOk());
}

TEST(Recipe, KeepsWhatIsSetWhenFillingDefaults) {
  v1::Recipe recipe;
  recipe.mutable_ppo()->set_epochs(7);
  recipe.mutable_ppo()->set_gae_lambda(0);
  recipe.mutable_task()->mutable_action()->set_range_margin(0);
  recipe.mutable_task()->mutable_reward()->set_rotation_weight(0);

  recipe = WithDefaults(recipe);

  EXPECT_EQ(recipe.ppo().epochs(), 7);
  EXPECT_EQ(recipe.ppo().gae_lambda(), 0);
  EXPECT_EQ(recipe.ppo().discount(), 0.95);
  EXPECT_EQ(recipe.task().action().range_margin(), 0);
  EXPECT_EQ(recipe.task().reward().rotation_weight(), 0);
  EXPECT_EQ(recipe.task().reward().position_weight(), 0.5);
}

TEST(Recipe, FillsDefaultsOnceAndForAll) {
  EXPECT_THAT(WithDefaults(MakeRecipe()), EqualsProto(MakeRecipe()));
}

TEST(Recipe, DelaysEvaluationsByTheLag) {
  v1::Recipe recipe;
  recipe.mutable_rollouts()->set_max_policy_lag(1);

  recipe = WithDefaults(recipe);

  EXPECT_EQ(recipe.evaluation().delay(), 2);
  EXPECT_THAT(ValidateRecipe(recipe), IsOk());
}

TEST(Recipe, SurvivesPrintingAndParsing) {
  const v1::Recipe recipe =
      MakeRecipe({"seed=18446744073709551615", "task.action.ramp=true",
                  "ppo.policy_learning_rate=0.1234567890123456",
                  "ppo.gae_lambda=0", "name=walk"});

  EXPECT_THAT(ParseRecipe(PrintRecipe(recipe), "config.textproto"),
              IsOkAndHolds(EqualsProto(recipe)));
}

TEST(Recipe, NamesFileLineAndUnknownField) {
  EXPECT_THAT(ParseRecipe("name: \"x\"\nppo { epoch: 2 }", "my.textproto"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("my.textproto:2:"),
                             HasSubstr("\"sinew.v1.Ppo\" has no field named "
                                       "\"epoch\""),
                             HasSubstr("The nearest is \"epochs\""))));
}

TEST(Recipe, NamesFileLineAndAValueOfTheWrongType) {
  EXPECT_THAT(ParseRecipe("ppo {\n  epochs: \"two\"\n}", "my.textproto"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("my.textproto:2:"),
                             HasSubstr("Expected integer, got: \"two\""))));
  EXPECT_THAT(ParseRecipe("device: 3", "my.textproto"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("my.textproto:1:")));
}

struct Violation {
  std::vector<std::string> assignments;
  // The message after "recipe field ".
  std::string expected;
};

void PrintTo(const Violation& violation, std::ostream* os) {
  *os << violation.assignments.front();
}

class RecipeViolation : public ::testing::TestWithParam<Violation> {};

TEST_P(RecipeViolation, IsRefusedByNameOfField) {
  EXPECT_THAT(ValidateRecipe(MakeRecipe(GetParam().assignments)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       absl::StrCat("recipe field ", GetParam().expected)));
}

INSTANTIATE_TEST_SUITE_P(
    Ranges, RecipeViolation,
    ::testing::Values(
        Violation{{"format_version=2"}, "format_version: expected 1, found 2"},
        Violation{{"name=Walk it"},
                  "name: expected lower-case letters, digits and _, found "
                  "\"Walk it\""},
        Violation{{"device=tpu"},
                  "device: expected \"cpu\" or \"cuda\", found \"tpu\""},
        Violation{{"ppo.value_warmup_iterations=-1"},
                  "ppo.value_warmup_iterations: expected >= 0, found -1"},
        Violation{{"ppo.value_warmup_iterations=5", "max_iterations=5"},
                  "max_iterations: expected > ppo.value_warmup_iterations (5), "
                  "or the policy would never learn, found 5"},
        Violation{{"max_minutes=-1"}, "max_minutes: expected >= 0, found -1"},
        Violation{{"task.action.scale=-1"},
                  "task.action.scale: expected > 0, found -1"},
        Violation{{"task.action.scale=nan"},
                  "task.action.scale: expected > 0, found nan"},
        Violation{{"task.action.clip=inf"},
                  "task.action.clip: expected > 0, found inf"},
        Violation{{"task.action.range_margin=-0.5"},
                  "task.action.range_margin: expected >= 0, found -0.5"},
        Violation{{"task.start.carry_on_share=1"},
                  "task.start.carry_on_share: expected [0, 1), found 1"},
        Violation{{"task.start.carry_on_share=nan"},
                  "task.start.carry_on_share: expected [0, 1), found nan"},
        Violation{{"task.start.carry_on_seconds=3"},
                  "task.start.carry_on_seconds: expected unset, since "
                  "task.start.carry_on_share is 0, found 3"},
        Violation{
            {"task.start.carry_on_share=0.5", "task.start.carry_on_seconds=-1"},
            "task.start.carry_on_seconds: expected > 0, found -1"},
        Violation{{"task.start.carry_on_share=0.5",
                   "task.start.carry_on_seconds=1e7"},
                  "task.start.carry_on_seconds: expected within [0, 1000000], "
                  "found 10000000"},
        Violation{{"task.start.uniform_share=1.5"},
                  "task.start.uniform_share: expected within [0, 1], found "
                  "1.5"},
        Violation{{"task.start.only_clips=[walk,run,walk]"},
                  "task.start.only_clips: expected each clip at most once, "
                  "found \"walk\""},
        Violation{{"task.start.adaptive.pre_failure_seconds=-1"},
                  "task.start.adaptive.pre_failure_seconds: expected within "
                  "[0, 1000000], found -1"},
        Violation{{"task.start.adaptive.pre_failure_seconds=1e9"},
                  "task.start.adaptive.pre_failure_seconds: expected within "
                  "[0, 1000000], found 1000000000"},
        Violation{{"task.start.bin_seconds=1e9"},
                  "task.start.bin_seconds: expected within [0, 1000000], found "
                  "1000000000"},
        Violation{{"task.start.adaptive.half_life_passages=-1"},
                  "task.start.adaptive.half_life_passages: expected >= 0, "
                  "found -1"},
        Violation{{"task.start.rule=adaptive_bins"},
                  "task.start.adaptive.half_life_passages: expected > 0, "
                  "found 0"},
        Violation{{"task.start.rule=adaptive_bins",
                   "task.start.adaptive.half_life_passages=1"},
                  "task.start.adaptive.clip_cap: expected > 0, found 0"},
        Violation{{"task.start.adaptive.bin_floor=1.5"},
                  "task.start.adaptive.bin_floor: expected within [0, 1], "
                  "found 1.5"},
        Violation{{"task.start.adaptive.clip_floor=-0.1"},
                  "task.start.adaptive.clip_floor: expected within [0, 1], "
                  "found -0.1"},
        Violation{{"task.start.adaptive.clip_cap=2"},
                  "task.start.adaptive.clip_cap: expected within [0, 1], "
                  "found 2"},
        Violation{{"task.observation.frames_ahead=[1,0]"},
                  "task.observation.frames_ahead: expected within [1, 10000], "
                  "found 0"},
        Violation{{"task.observation.blocks=[unspecified]"},
                  "task.observation.blocks: expected a known block, found 0"},
        Violation{{"task.observation.blocks=[self_contact,self_contact]"},
                  "task.observation.blocks: expected each block at most once, "
                  "found \"BLOCK_SELF_CONTACT\""},
        Violation{{"network.policy_hidden=[256,0]"},
                  "network.policy_hidden: expected within [1, 16384], found "
                  "0"},
        Violation{{"rollouts.replay_bytes=1048575"},
                  "rollouts.replay_bytes: expected >= 1048576, found 1048575"},
        Violation{{"rollouts.max_policy_lag=2"},
                  "rollouts.max_policy_lag: expected within [0, 1], found 2"},
        Violation{{"ppo.discount=1"},
                  "ppo.discount: expected within (0, 1), found 1"},
        Violation{{"ppo.anneal.std_factor=2"},
                  "ppo.anneal.std_factor: expected within [0, 1], found 2"},
        Violation{{"evaluation.interval=-1"},
                  "evaluation.interval: expected >= 0, found -1"},
        Violation{{"checkpointing.keep=0"},
                  "checkpointing.keep: expected >= 1, found 0"}));

INSTANTIATE_TEST_SUITE_P(
    Together, RecipeViolation,
    ::testing::Values(
        Violation{{"physics.physics_hz=100"},
                  "physics.physics_hz: expected a multiple of "
                  "physics.control_hz (30), found 100"},
        Violation{{"physics.physics_hz=15"},
                  "physics.physics_hz: expected a multiple of "
                  "physics.control_hz (30), found 15"},
        Violation{{"rollouts.environments=100"},
                  "rollouts.environments: expected a multiple of "
                  "rollouts.environments_per_order (8), found 100"},
        // 128 * 64 = 8192.
        Violation{{"ppo.minibatch=3000"},
                  "ppo.minibatch: expected a divisor of the batch "
                  "(rollouts.environments * rollouts.horizon = 8192), found "
                  "3000"},
        Violation{{"ppo.shards=3"},
                  "ppo.shards: expected a divisor of ppo.minibatch (2048), "
                  "found 3"},
        Violation{
            {"task.reward.position_weight=0", "task.reward.rotation_weight=0",
             "task.reward.linear_velocity_weight=0",
             "task.reward.angular_velocity_weight=0"},
            "task.reward: expected weights that are not all 0, found 0"},
        Violation{{"task.action.placement=absolute",
                   "task.action.torque_feedforward=true"},
                  "task.action.torque_feedforward: expected false unless "
                  "task.action.placement is PLACEMENT_AROUND_NEXT_REFERENCE, "
                  "found true"},
        Violation{{"ppo.anneal.success_share=0.5"},
                  "evaluation.interval: expected >= 1, since ppo.anneal waits "
                  "for evaluations, found 0"},
        Violation{{"task.start.rule=phc_soft"},
                  "evaluation.interval: expected >= 1, since task.start "
                  "follows evaluations, found 0"},
        Violation{{"task.start.rule=phc_hard"},
                  "evaluation.interval: expected >= 1, since task.start "
                  "follows evaluations, found 0"},
        Violation{{"task.start.rule=adaptive_bins",
                   "task.start.adaptive.half_life_passages=1",
                   "task.start.adaptive.clip_cap=1",
                   "task.start.adaptive.clip_weight=CLIP_WEIGHT_EVALUATIONS"},
                  "evaluation.interval: expected >= 1, since task.start "
                  "follows evaluations, found 0"}));

// Configurations that would wait for ever.
INSTANTIATE_TEST_SUITE_P(
    Deadlocks, RecipeViolation,
    ::testing::Values(
        Violation{{"rollouts.max_policy_lag=1", "evaluation.interval=5"},
                  "evaluation.delay: expected >= 2 (rollouts.max_policy_lag + "
                  "1), or the learner would wait for itself, found 1"},
        Violation{{"evaluation.delay=3"},
                  "evaluation.delay: expected within [1, 2], found 3"},
        Violation{{"evaluation.delay=2", "evaluation.interval=1"},
                  "evaluation.delay: expected <= evaluation.interval (1), "
                  "found 2"}));

// Sets each floating-point field below `message` to NaN, one at a time, and
// expects that the recipe is refused by the field's name.
void ExpectEveryNanRefused(v1::Recipe& recipe, Message& message,
                           const std::string& path) {
  const auto* type = message.GetDescriptor();
  const auto* reflection = message.GetReflection();
  for (int i = 0; i < type->field_count(); ++i) {
    const FieldDescriptor* field = type->field(i);
    if (field->is_repeated()) continue;
    const std::string name = absl::StrCat(path, field->name());
    if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
      const bool was_set = reflection->HasField(message, field);
      ExpectEveryNanRefused(recipe,
                            *reflection->MutableMessage(&message, field),
                            absl::StrCat(name, "."));
      // To set some groups is to ask for what they are about.
      if (!was_set) reflection->ClearField(&message, field);
    } else if (field->cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE) {
      const bool was_set = reflection->HasField(message, field);
      const double before = reflection->GetDouble(message, field);
      reflection->SetDouble(&message, field,
                            std::numeric_limits<double>::quiet_NaN());
      EXPECT_THAT(ValidateRecipe(recipe),
                  StatusIs(absl::StatusCode::kInvalidArgument,
                           HasSubstr("recipe field ")))
          << name;
      reflection->SetDouble(&message, field, before);
      if (!was_set) reflection->ClearField(&message, field);
    }
  }
}

TEST(Recipe, RefusesNanInEveryField) {
  v1::Recipe recipe = MakeRecipe();

  ExpectEveryNanRefused(recipe, recipe, "");

  EXPECT_THAT(ValidateRecipe(recipe), IsOk());
}

}  // namespace
}  // namespace sinew
