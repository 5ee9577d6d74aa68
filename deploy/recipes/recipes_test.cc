// What every shipped recipe must be.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "common/config/recipe.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "common/workspace_files.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew {
namespace {

using ::sinew::testing::EqualsProto;
using ::sinew::testing::IsOk;
using ::testing::ElementsAre;

// A shipped recipe, with defaults.
v1::Recipe Load(const std::string& name) {
  const auto path = FindWorkspaceFile("deploy/recipes/" + name + ".textproto");
  EXPECT_THAT(path, IsOk());
  const auto text = ReadFile(*path);
  EXPECT_THAT(text, IsOk());
  auto recipe = ParseRecipe(*text, *path);
  EXPECT_THAT(recipe, IsOk());
  return WithDefaults(*std::move(recipe));
}

class RecipesTest : public ::testing::TestWithParam<std::string> {
 protected:
  const v1::Recipe recipe_ = Load(GetParam());
};

TEST_P(RecipesTest, IsValidAndNamedAsItsFile) {
  EXPECT_EQ(recipe_.name(), GetParam());
  EXPECT_THAT(ValidateRecipe(recipe_), IsOk());
}

INSTANTIATE_TEST_SUITE_P(All, RecipesTest,
                         ::testing::Values("distil_experts",
                                           "distil_experts_g1", "get_up",
                                           "latent_rl", "phc_plus",
                                           "phc_plus_g1", "pulse", "pulse_g1",
                                           "pulse_no_bottleneck", "track_clip",
                                           "track_library", "track_library_g1"),
                         [](const auto& info) { return info.param; });

// A student's recipe and the one that its teacher was trained with.
void ExpectTeacher(const std::string& student, const std::string& teacher) {
  const v1::Recipe of_student = Load(student);
  const v1::Recipe of_teacher = Load(teacher);

  EXPECT_THAT(of_student.distillation().teacher_action(),
              EqualsProto(of_teacher.task().action()));
  EXPECT_THAT(of_student.task().observation(),
              EqualsProto(of_teacher.task().observation()));
  EXPECT_THAT(of_student.physics(), EqualsProto(of_teacher.physics()));
  EXPECT_THAT(of_student.task().randomisation(),
              EqualsProto(of_teacher.task().randomisation()));
  EXPECT_THAT(of_student.task().actuator_model(),
              EqualsProto(of_teacher.task().actuator_model()));
  EXPECT_THAT(of_student.task().recovery(),
              EqualsProto(of_teacher.task().recovery()));
  // A student learns from every clip, however often it fails elsewhere.
  v1::Start start = of_teacher.task().start();
  start.mutable_adaptive()->set_clip_floor(0.5);
  start.mutable_adaptive()->clear_clip_weight();
  EXPECT_THAT(of_student.task().start(), EqualsProto(start));
  EXPECT_THAT(of_student.evaluation(), EqualsProto(of_teacher.evaluation()));
}

TEST(StudentsTest, KnowTheActionLawAndTheWorldOfTheirTeacher) {
  ExpectTeacher("pulse", "track_library");
  ExpectTeacher("pulse_no_bottleneck", "track_library");
}

// Several primitives and a single one have the same task and network.
TEST(ProceduresTest, TrackWhatTheSinglePrimitiveDoes) {
  const v1::Recipe several = Load("phc_plus");
  const v1::Recipe single = Load("track_library");

  v1::Task tracking = several.task();
  tracking.clear_recovery();
  v1::Task alone = single.task();
  alone.clear_recovery();
  EXPECT_THAT(tracking, EqualsProto(alone));
  EXPECT_THAT(several.physics(), EqualsProto(single.physics()));
  EXPECT_THAT(several.rollouts(), EqualsProto(single.rollouts()));
  EXPECT_THAT(several.evaluation(), EqualsProto(single.evaluation()));
  v1::Network network = several.network();
  network.set_initial_std(single.network().initial_std());
  EXPECT_THAT(network, EqualsProto(single.network()));
}

// The upper bound acts by its teacher's law and learns as suits it.
TEST(StudentsTest, AreTaughtTheSameInTheSameWorld) {
  v1::Recipe pulse = Load("pulse");
  v1::Recipe plain = Load("pulse_no_bottleneck");
  EXPECT_TRUE(pulse.network().has_latent());
  EXPECT_FALSE(plain.network().has_latent());
  EXPECT_THAT(plain.task().action(),
              EqualsProto(plain.distillation().teacher_action()));
  for (v1::Recipe* recipe : {&pulse, &plain}) {
    recipe->clear_name();
    recipe->clear_network();
    recipe->mutable_task()->clear_action();
    v1::Distillation taught;
    *taught.mutable_teacher_action() = recipe->distillation().teacher_action();
    *recipe->mutable_distillation() = taught;
  }

  EXPECT_THAT(pulse, EqualsProto(plain));
}

// Its teachers are track_clip's, and PPO can go on with its bundle as with one
// of track_library (--init).
TEST(StudentsTest, OfExpertsActsAsTrackLibrary) {
  const v1::Recipe student = Load("distil_experts");
  const v1::Recipe clip = Load("track_clip");
  const v1::Recipe library = Load("track_library");

  EXPECT_THAT(student.distillation().teacher_action(),
              EqualsProto(clip.task().action()));
  EXPECT_THAT(student.task().observation(),
              EqualsProto(clip.task().observation()));
  EXPECT_THAT(student.physics(), EqualsProto(clip.physics()));
  EXPECT_THAT(student.physics(), EqualsProto(library.physics()));
  EXPECT_FALSE(student.task().has_randomisation());
  EXPECT_FALSE(student.task().has_actuator_model());
  EXPECT_FALSE(student.task().has_recovery());
  EXPECT_EQ(student.network().activation(), library.network().activation());
  EXPECT_EQ(student.network().observation_clip(),
            library.network().observation_clip());
  EXPECT_THAT(student.task().action(), EqualsProto(library.task().action()));
  EXPECT_THAT(student.task().observation(),
              EqualsProto(library.task().observation()));
  EXPECT_THAT(student.network().policy_hidden(),
              ::testing::ElementsAreArray(library.network().policy_hidden()));
  EXPECT_FALSE(student.network().has_latent());
}

// Single policies, students and procedures of the G1 are of one world and see
// the same, but for the previous target, which a prior sees as well.
TEST(G1Test, IsTheSameWorldInEveryRecipe) {
  const v1::Recipe track = Load("track_library_g1");
  for (const char* name : {"phc_plus_g1", "pulse_g1", "distil_experts_g1"}) {
    const v1::Recipe other = Load(name);
    EXPECT_THAT(other.physics(), EqualsProto(track.physics())) << name;
    EXPECT_THAT(other.task().randomisation(),
                EqualsProto(track.task().randomisation()))
        << name;
    EXPECT_THAT(other.task().actuator_model(),
                EqualsProto(track.task().actuator_model()))
        << name;
  }
  const v1::Recipe student = Load("distil_experts_g1");
  EXPECT_THAT(student.task().action(), EqualsProto(track.task().action()));
  EXPECT_THAT(Load("phc_plus_g1").task().observation(),
              EqualsProto(track.task().observation()));
  v1::Recipe latent = Load("pulse_g1");
  for (const v1::Recipe& one : {student, latent}) {
    EXPECT_THAT(one.distillation().teacher_action(),
                EqualsProto(track.task().action()));
  }
  // One's teachers may be the other's.
  v1::Task& task = *latent.mutable_task();
  *task.mutable_action() = student.task().action();
  EXPECT_THAT(task.observation().blocks(),
              ElementsAre(v1::Observation::BLOCK_SELF_JOINT_SPACE,
                          v1::Observation::BLOCK_PREVIOUS_TARGET,
                          v1::Observation::BLOCK_REFERENCE_DIFFERENCE));
  *task.mutable_observation() = student.task().observation();
  task.mutable_start()->clear_carry_on_share();
  task.mutable_start()->clear_carry_on_seconds();
  EXPECT_THAT(task, EqualsProto(student.task()));
}

// The lower bound: pulse, but for how it learns.
TEST(LatentRlTest, IsPulseLearntAsTrackLibraryIs) {
  v1::Recipe pulse = Load("pulse");
  const v1::Recipe bound = Load("latent_rl");
  const v1::Recipe track = Load("track_library");
  pulse.set_name(bound.name());
  pulse.clear_distillation();
  *pulse.mutable_ppo() = track.ppo();
  pulse.mutable_ppo()->set_latent_kl_weight(0.01);
  *pulse.mutable_network()->mutable_value_hidden() =
      track.network().value_hidden();

  EXPECT_THAT(bound, EqualsProto(pulse));
}

TEST(StudentsTest, OfTheG1DifferInTheirWorldAndHowOftenTheyLearn) {
  v1::Recipe pulse = Load("pulse");
  const v1::Recipe g1 = Load("pulse_g1");
  pulse.set_name(g1.name());
  v1::Task& task = *pulse.mutable_task();
  *task.mutable_termination() = g1.task().termination();
  task.mutable_start()->set_bin_seconds(g1.task().start().bin_seconds());
  *task.mutable_randomisation() = g1.task().randomisation();
  *task.mutable_actuator_model() = g1.task().actuator_model();
  // Its physics takes most of the time: it learns more often from a sample,
  // with larger networks.
  v1::Latent& latent = *pulse.mutable_network()->mutable_latent();
  EXPECT_GT(g1.network().latent().encoder_hidden(0), latent.encoder_hidden(0));
  *latent.mutable_encoder_hidden() = g1.network().latent().encoder_hidden();
  *latent.mutable_decoder_hidden() = g1.network().latent().decoder_hidden();
  const v1::Distillation& often = g1.distillation();
  v1::Distillation& once = *pulse.mutable_distillation();
  EXPECT_GT(often.samples_per_insert(), once.samples_per_insert());
  once.set_samples_per_insert(often.samples_per_insert());
  once.mutable_memory()->set_rows(often.memory().rows());
  once.set_learning_rate_final(often.learning_rate_final());
  once.set_rate_anneal_begin(often.rate_anneal_begin());
  once.set_rate_anneal_end(often.rate_anneal_end());
  // Its prior acts while it learns, and sees the previous target.
  EXPECT_GT(often.prior_share(), 0);
  once.set_prior_share(often.prior_share());
  once.set_prior_noise(often.prior_noise());
  once.set_prior_steps(often.prior_steps());
  once.set_prior_seconds_ahead(often.prior_seconds_ahead());
  once.set_prior_first_episode(often.prior_first_episode());
  *task.mutable_observation() = g1.task().observation();
  task.mutable_start()->set_carry_on_share(g1.task().start().carry_on_share());
  task.mutable_start()->set_carry_on_seconds(
      g1.task().start().carry_on_seconds());

  EXPECT_THAT(pulse, EqualsProto(g1));
}

}  // namespace
}  // namespace sinew
