// Distillation, and latents that are distilled, in ValidateRecipe and
// WithDefaults.

#include <limits>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/config/recipe.h"
#include "common/config/testing/recipe_assignments.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "google/protobuf/descriptor.h"
#include "google/protobuf/message.h"
#include "gtest/gtest.h"

namespace sinew {
namespace {

using ::sinew::testing::EqualsProto;
using ::sinew::testing::IsOk;
using ::sinew::testing::MakeRecipe;
using ::sinew::testing::StatusIs;
using ::sinew::testing::Violation;
using ::testing::HasSubstr;

// The least that a student with a latent needs, and more.
v1::Recipe MakeStudent(const std::vector<std::string>& more = {}) {
  std::vector<std::string> assignments = {"distillation.learning_rate=5e-4",
                                          "network.latent.width=32",
                                          "task.action.placement=absolute"};
  assignments.insert(assignments.end(), more.begin(), more.end());
  return MakeRecipe(assignments);
}

TEST(Imitation, IsAbsentFromARecipeThatDoesNotAskForIt) {
  const v1::Recipe recipe = MakeRecipe({});

  EXPECT_FALSE(recipe.has_distillation());
  EXPECT_FALSE(recipe.network().has_latent());
}

TEST(Imitation, HasTheDefaultsOfItsComments) {
  const v1::Recipe recipe = MakeStudent();

  EXPECT_THAT(recipe.distillation(),
              EqualsProto("teacher_action {"
                          "  placement: PLACEMENT_AROUND_NEXT_REFERENCE"
                          "  scale: 0.2 clip: 8 range_margin: 1.5 }"
                          "form: FORM_CODE learning_rate: 5e-4 "
                          "max_gradient_norm: 50 minibatch: 2048 "
                          "samples_per_insert: 4 shards: 2 kl_weight: 0.01 "
                          "kl_weight_final: 0.001 continuity_weight: 0.005 "
                          "memory { rows: 65536 selector: SELECTOR_UNIFORM "
                          "         priority_exponent: 0.6 }"));
  EXPECT_THAT(recipe.network().latent(),
              EqualsProto("width: 32 encoder_hidden: 512 encoder_hidden: 256 "
                          "prior_hidden: 512 prior_hidden: 256 "
                          "decoder_hidden: 512 decoder_hidden: 256 "
                          "log_variance_low: -5 log_variance_high: 2"));
  EXPECT_THAT(ValidateRecipe(recipe), IsOk());
  EXPECT_THAT(WithDefaults(recipe), EqualsProto(recipe));
}

TEST(Imitation, HasAFinalRateWhereTheRateFallsAlone) {
  EXPECT_EQ(MakeStudent().distillation().learning_rate_final(), 0);
  EXPECT_EQ(MakeStudent({"distillation.rate_anneal_end=9"})
                .distillation()
                .learning_rate_final(),
            5e-4);
}

TEST(Imitation, SaysHowThePriorActsWhereItDoesAlone) {
  const v1::Distillation never = MakeStudent().distillation();
  EXPECT_FALSE(never.has_prior_noise());
  EXPECT_EQ(never.prior_steps(), 0);
  const v1::Distillation acts =
      MakeStudent({"distillation.prior_share=0.5"}).distillation();
  EXPECT_EQ(acts.prior_noise(), 1);
  EXPECT_EQ(acts.prior_steps(), 4);
  EXPECT_EQ(never.prior_seconds_ahead(), 0);
  EXPECT_EQ(acts.prior_seconds_ahead(), 0.5);
  const v1::Distillation own =
      MakeStudent({"distillation.prior_share=0.5", "distillation.prior_noise=0",
                   "distillation.prior_steps=3"})
          .distillation();
  EXPECT_EQ(own.prior_noise(), 0);
  EXPECT_EQ(own.prior_steps(), 3);
}

TEST(Imitation, KeepsWhatIsSetWhenFillingDefaults) {
  const v1::Recipe recipe = MakeStudent(
      {"distillation.kl_weight=0", "distillation.kl_weight_final=0",
       "distillation.continuity_weight=0",
       "distillation.memory.priority_exponent=0", "distillation.form=paper",
       "distillation.teacher_share=0.25", "network.latent.log_variance_high=0",
       "network.latent.prior_hidden=[64]"});

  EXPECT_EQ(recipe.distillation().kl_weight(), 0);
  EXPECT_EQ(recipe.distillation().continuity_weight(), 0);
  EXPECT_EQ(recipe.distillation().memory().priority_exponent(), 0);
  EXPECT_EQ(recipe.distillation().form(), v1::Distillation::FORM_PAPER);
  EXPECT_EQ(recipe.network().latent().log_variance_high(), 0);
  EXPECT_EQ(recipe.network().latent().prior_hidden_size(), 1);
  EXPECT_THAT(ValidateRecipe(recipe), IsOk());
}

TEST(Imitation, HasAPriorThatActsOnlyWithALatent) {
  EXPECT_THAT(ValidateRecipe(MakeStudent({"distillation.prior_share=0.5"})),
              IsOk());
  EXPECT_THAT(ValidateRecipe(MakeRecipe({"distillation.learning_rate=1e-3",
                                         "distillation.prior_share=0.5"})),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("recipe field distillation.prior_share: "
                                 "expected 0, since network.latent is unset")));
}

TEST(Imitation, NeedsNoLatentAndThenNoParticularLawOrObservation) {
  EXPECT_THAT(ValidateRecipe(MakeRecipe(
                  {"distillation.learning_rate=1e-3",
                   "task.observation.blocks=[reference_difference]"})),
              IsOk());
}

// ppo is unused, so its sizes need not fit.
TEST(Imitation, LooksAtNoMinibatchOfPpo) {
  EXPECT_THAT(ValidateRecipe(MakeStudent({"rollouts.environments=24",
                                          "rollouts.horizon=16",
                                          "distillation.minibatch=64"})),
              IsOk());
}

TEST(Imitation, TakesTheBodiesForTheBodysOwnState) {
  EXPECT_THAT(ValidateRecipe(MakeStudent({"task.observation.blocks=["
                                          "self_bodies,reference_bodies]"})),
              IsOk());
}

TEST(Imitation, CountsTheBodysOwnBlocks) {
  EXPECT_EQ(LeadingSelfBlocks(MakeRecipe({}).task().observation()), 1);
  EXPECT_EQ(
      LeadingSelfBlocks(
          MakeRecipe({"task.observation.blocks=[self_contact,previous_target,"
                      "self_joint_space,self_bodies,reference_bodies,"
                      "reference_contact]"})
              .task()
              .observation()),
      4);
  EXPECT_EQ(LeadingSelfBlocks(
                MakeRecipe({"task.observation.blocks=[reference_keypoints,"
                            "self_contact]"})
                    .task()
                    .observation()),
            0);
}

class ImitationViolation : public ::testing::TestWithParam<Violation> {};

TEST_P(ImitationViolation, IsRefusedByNameOfField) {
  EXPECT_THAT(ValidateRecipe(MakeStudent(GetParam().assignments)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       absl::StrCat("recipe field ", GetParam().expected)));
}

INSTANTIATE_TEST_SUITE_P(
    Latents, ImitationViolation,
    ::testing::Values(
        Violation{{"network.latent.width=1025"},
                  "network.latent.width: expected within [1, 1024], found "
                  "1025"},
        Violation{{"network.latent.encoder_hidden=[64,0]"},
                  "network.latent.encoder_hidden: expected within [1, 16384], "
                  "found 0"},
        Violation{{"network.latent.prior_hidden=[20000]"},
                  "network.latent.prior_hidden: expected within [1, 16384], "
                  "found 20000"},
        Violation{{"network.latent.decoder_hidden=[-1]"},
                  "network.latent.decoder_hidden: expected within [1, 16384], "
                  "found -1"},
        Violation{{"network.latent.log_variance_low=2"},
                  "network.latent.log_variance_low: expected < "
                  "network.latent.log_variance_high (2), found 2"},
        Violation{{"network.composer.primitives=2"},
                  "network.composer: expected unset, since network.latent is "
                  "set, found \"set\""},
        Violation{{"task.action.placement=around_next_reference"},
                  "task.action.placement: expected PLACEMENT_AROUND_CURRENT or "
                  "PLACEMENT_ABSOLUTE, since the decoder of network.latent "
                  "sees no reference, found "
                  "\"PLACEMENT_AROUND_NEXT_REFERENCE\""},
        Violation{{"task.observation.blocks=[reference_difference,"
                   "self_joint_space]"},
                  "task.observation.blocks: expected the body's own blocks "
                  "first, then those of the goal, at least one of each, since "
                  "network.latent is set, found \"0 own blocks, then 2 "
                  "others\""},
        Violation{{"task.observation.blocks=[self_joint_space,self_contact]"},
                  "task.observation.blocks: expected the body's own blocks "
                  "first, then those of the goal, at least one of each, since "
                  "network.latent is set, found \"2 own blocks, then 0 "
                  "others\""},
        Violation{{"task.observation.blocks=[self_joint_space,"
                   "reference_bodies,self_bodies]"},
                  "task.observation.blocks: expected all of the body's own "
                  "blocks before those of the goal, since network.latent is "
                  "set, found \"BLOCK_SELF_BODIES\""},
        Violation{{"task.observation.blocks=[self_joint_space,"
                   "reference_difference,previous_target]"},
                  "task.observation.blocks: expected all of the body's own "
                  "blocks before those of the goal, since network.latent is "
                  "set, found \"BLOCK_PREVIOUS_TARGET\""}));

INSTANTIATE_TEST_SUITE_P(
    Distillations, ImitationViolation,
    ::testing::Values(
        Violation{{"distillation.learning_rate=-1"},
                  "distillation.learning_rate: expected > 0, found -1"},
        Violation{{"distillation.learning_rate_final=-1",
                   "distillation.rate_anneal_end=9"},
                  "distillation.learning_rate_final: expected > 0 and <= "
                  "distillation.learning_rate (0.0005), found -1"},
        Violation{{"distillation.learning_rate_final=6e-4",
                   "distillation.rate_anneal_end=9"},
                  "distillation.learning_rate_final: expected > 0 and <= "
                  "distillation.learning_rate (0.0005), found 0.0006"},
        Violation{{"distillation.learning_rate_final=1e-4"},
                  "distillation.rate_anneal_end: expected > 0, since "
                  "distillation.learning_rate_final is set, found 0"},
        Violation{{"distillation.rate_anneal_begin=-1"},
                  "distillation.rate_anneal_begin: expected >= 0, found -1"},
        Violation{{"distillation.rate_anneal_begin=10",
                   "distillation.rate_anneal_end=9"},
                  "distillation.rate_anneal_end: expected >= "
                  "distillation.rate_anneal_begin (10), found 9"},
        Violation{{"distillation.samples_per_insert=-1"},
                  "distillation.samples_per_insert: expected > 0, found -1"},
        Violation{{"distillation.samples_per_insert=1025"},
                  "distillation.samples_per_insert: expected <= 1024, or one "
                  "update would take hours, found 1025"},
        Violation{{"distillation.kl_weight=-0.5"},
                  "distillation.kl_weight: expected >= 0, found -0.5"},
        Violation{{"distillation.kl_anneal_begin=-1"},
                  "distillation.kl_anneal_begin: expected >= 0, found -1"},
        Violation{{"distillation.kl_anneal_begin=10"},
                  "distillation.kl_anneal_end: expected >= "
                  "distillation.kl_anneal_begin (10), found 0"},
        Violation{{"distillation.continuity_weight=-1"},
                  "distillation.continuity_weight: expected >= 0, found -1"},
        Violation{{"distillation.teacher_share=1.5"},
                  "distillation.teacher_share: expected within [0, 1], found "
                  "1.5"},
        Violation{{"distillation.action_noise=-0.5"},
                  "distillation.action_noise: expected within [0, 100], found "
                  "-0.5"},
        Violation{{"distillation.prior_share=-0.5"},
                  "distillation.prior_share: expected within [0, 1], found "
                  "-0.5"},
        Violation{
            {"distillation.teacher_share=0.75", "distillation.prior_share=0.5"},
            "distillation.prior_share: expected <= 1 - "
            "distillation.teacher_share (0.25), found 0.5"},
        Violation{{"distillation.prior_share=1"},
                  "distillation.prior_share: expected < 1, since what the "
                  "student leads itself is what observations are normalised "
                  "by, found 1"},
        Violation{{"distillation.prior_noise=1"},
                  "distillation.prior_noise: expected unset, since "
                  "distillation.prior_share is 0, found 1"},
        Violation{{"distillation.prior_steps=4"},
                  "distillation.prior_steps: expected unset, since "
                  "distillation.prior_share is 0, found 4"},
        Violation{
            {"distillation.prior_share=0.5", "distillation.prior_noise=-1"},
            "distillation.prior_noise: expected within [0, 100], found -1"},
        Violation{
            {"distillation.prior_share=0.5", "distillation.prior_steps=-1"},
            "distillation.prior_steps: expected >= 1, found -1"},
        Violation{{"distillation.prior_first_episode=9"},
                  "distillation.prior_first_episode: expected unset, since "
                  "distillation.prior_share is 0, found 9"},
        Violation{{"distillation.prior_seconds_ahead=2"},
                  "distillation.prior_seconds_ahead: expected unset, since "
                  "distillation.prior_share is 0, found 2"},
        Violation{{"distillation.prior_share=0.5",
                   "distillation.prior_seconds_ahead=-2"},
                  "distillation.prior_seconds_ahead: expected > 0, found -2"},
        Violation{{"distillation.prior_share=0.5",
                   "distillation.prior_seconds_ahead=1e7"},
                  "distillation.prior_seconds_ahead: expected within [0, "
                  "1000000], found 10000000"},
        Violation{{"distillation.prior_share=0.5",
                   "distillation.prior_first_episode=-9"},
                  "distillation.prior_first_episode: expected >= 0, found -9"},
        Violation{{"distillation.teacher_action.clip=-1"},
                  "distillation.teacher_action.clip: expected > 0, found -1"},
        Violation{{"distillation.memory.priority_exponent=2"},
                  "distillation.memory.priority_exponent: expected within [0, "
                  "1], found 2"},
        // 128 * 64.
        Violation{{"distillation.memory.rows=8191"},
                  "distillation.memory.rows: expected >= the rows of an "
                  "iteration (rollouts.environments * rollouts.horizon = "
                  "8192), found 8191"},
        Violation{{"distillation.minibatch=100"},
                  "distillation.minibatch: expected a multiple of "
                  "rollouts.horizon (64), found 100"},
        Violation{{"distillation.shards=3"},
                  "distillation.shards: expected a divisor of the sequences of "
                  "a minibatch (distillation.minibatch / rollouts.horizon = "
                  "32), found 3"}));

INSTANTIATE_TEST_SUITE_P(
    Together, ImitationViolation,
    ::testing::Values(
        Violation{{"distillation.teacher_action.ramp=true"},
                  "distillation.teacher_action.ramp: expected the same as "
                  "task.action.ramp, or the student's body would follow the "
                  "teacher's targets in another way, found true"},
        Violation{{"task.action.range_margin=1"},
                  "task.action.range_margin: expected >= "
                  "distillation.teacher_action.range_margin (1.5), or some of "
                  "the teacher's targets would be out of reach, found 1"},
        Violation{{"ppo.mirror=true"},
                  "ppo.mirror: expected unset, since ppo is unused where "
                  "distillation is set, found true"},
        Violation{{"ppo.bfloat16=true"},
                  "ppo.bfloat16: expected unset, since ppo is unused where "
                  "distillation is set (distillation.bfloat16 is the "
                  "student's), found true"},
        Violation{{"ppo.kl_target=0.04"},
                  "ppo.kl_target: expected unset, since ppo is unused where "
                  "distillation is set, found 0.04"},
        Violation{{"ppo.value_warmup_iterations=5"},
                  "ppo.value_warmup_iterations: expected unset, since ppo is "
                  "unused where distillation is set, found 5"},
        Violation{{"evaluation.interval=10", "ppo.anneal.success_share=0.5"},
                  "ppo.anneal.success_share: expected unset, since ppo is "
                  "unused where distillation is set, found 0.5"}));

TEST(Imitation, AProcedureIsRefused) {
  EXPECT_THAT(
      ValidateRecipe(MakeRecipe(
          {"distillation.learning_rate=1e-3", "evaluation.interval=10",
           "plateau.evaluations=3", "procedure.full_samples=1000",
           "procedure.hard_samples=500"})),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("recipe field procedure: expected unset, since "
                         "distillation is set")));
}

// Numbers that are not numbers, one at a time, in a message of the recipe.
void ExpectNansRefused(v1::Recipe& recipe, google::protobuf::Message& message) {
  using google::protobuf::FieldDescriptor;
  const auto* type = message.GetDescriptor();
  const auto* reflection = message.GetReflection();
  for (int i = 0; i < type->field_count(); ++i) {
    const FieldDescriptor* field = type->field(i);
    if (field->cpp_type() != FieldDescriptor::CPPTYPE_DOUBLE) continue;
    const double before = reflection->GetDouble(message, field);
    reflection->SetDouble(&message, field,
                          std::numeric_limits<double>::quiet_NaN());
    EXPECT_THAT(ValidateRecipe(recipe),
                StatusIs(absl::StatusCode::kInvalidArgument,
                         HasSubstr(std::string(field->name()))));
    reflection->SetDouble(&message, field, before);
  }
}

TEST(Imitation, RefusesNan) {
  v1::Recipe recipe = MakeStudent({"distillation.prior_share=0.5"});

  ExpectNansRefused(recipe, *recipe.mutable_distillation());
  ExpectNansRefused(recipe,
                    *recipe.mutable_distillation()->mutable_teacher_action());
  ExpectNansRefused(recipe, *recipe.mutable_network()->mutable_latent());

  EXPECT_THAT(ValidateRecipe(recipe), IsOk());
}

}  // namespace
}  // namespace sinew
