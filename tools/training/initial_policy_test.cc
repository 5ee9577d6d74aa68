// What a run may begin with, and what it refuses by bundle and field.

#include "tools/training/initial_policy.h"

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "common/config/recipe.h"
#include "common/files.h"
#include "common/policy/builder.h"
#include "common/policy/safetensors.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "sim/world/testing/toy_world.h"
#include "tools/training/testing/new_run.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;

// The toy world's recipe with small networks.
v1::Recipe SmallRecipe() {
  v1::Recipe recipe = world::testing::ToyRecipe();
  recipe.mutable_network()->mutable_policy_hidden()->Clear();
  recipe.mutable_network()->add_policy_hidden(8);
  recipe.mutable_network()->mutable_value_hidden()->Clear();
  recipe.mutable_network()->add_value_hidden(8);
  return recipe;
}

v1::Recipe ComposerRecipe() {
  v1::Recipe recipe = SmallRecipe();
  recipe.mutable_network()->mutable_composer()->set_primitives(2);
  recipe.mutable_network()->mutable_composer()->add_hidden(6);
  return recipe;
}

// A bundle of the toy world whose recipe was edited.
std::string WriteToy(
    const std::string& name,
    const std::function<void(v1::Recipe&)>& edit_recipe = nullptr) {
  v1::Recipe recipe = SmallRecipe();
  if (edit_recipe) edit_recipe(recipe);
  const world::testing::ToyWorld toy = world::testing::MakeToyWorld(recipe);
  const std::string directory = JoinPath(toy.folder, name);
  EXPECT_THAT(bundle::WriteBundle(bundle::testing::ToyContent(toy), directory),
              IsOk());
  return directory;
}

// A run of a composer, or of another recipe.
struct NewRun : testing::NewRun {
  explicit NewRun(const v1::Recipe& of_recipe = ComposerRecipe())
      : testing::NewRun(of_recipe) {}
};

TEST(InitialPolicy, ComposerTakesItsPrimitivesFromBundles) {
  const NewRun run;
  const std::string first = WriteToy("first"), second = WriteToy("second");

  ASSERT_THAT(run.Begin({.init = "", .primitives = {first, second}}), IsOk());

  const auto bundle = bundle::ReadBundle(second);
  ASSERT_THAT(bundle, IsOk());
  const TensorMap weights = run.learner->weights();
  for (const char* name : {"policy/linear_0/weight", "normaliser/mean"}) {
    EXPECT_EQ(weights.at(policy::PrimitiveParameter(1, name)).data,
              bundle->weights.at(name).data);
  }
}

TEST(InitialPolicy, RunOfOneNetworkNeedsNothing) {
  EXPECT_THAT(NewRun(SmallRecipe()).Begin({}), IsOk());
}

TEST(InitialPolicy, TakesAComposersBundleForAComposer) {
  const NewRun run;
  const std::string composer = WriteToy("composer", [](v1::Recipe& recipe) {
    *recipe.mutable_network() = ComposerRecipe().network();
  });

  ASSERT_THAT(run.Begin({.init = composer, .primitives = {}}), IsOk());

  EXPECT_EQ(run.learner->weights().at("composer/linear_0/weight").data,
            bundle::ReadBundle(composer)
                ->weights.at("composer/linear_0/weight")
                .data);
}

// A bundle of a policy that acts with its mean, as students do; `edit` may
// spoil its graph.
std::string WriteStudent(
    const std::string& name,
    const std::function<void(v1::Graph&)>& edit = nullptr) {
  const world::testing::ToyWorld toy =
      world::testing::MakeToyWorld(SmallRecipe());
  bundle::BundleContent content = bundle::testing::ToyContent(toy);
  v1::Graph& policy = *content.graph.mutable_graphs(0);
  EXPECT_EQ(policy.nodes(policy.nodes_size() - 3).name(), "mean");
  policy.mutable_nodes()->DeleteSubrange(policy.nodes_size() - 2, 2);
  policy.mutable_inputs()->DeleteSubrange(1, 1);
  for (v1::Tap& tap : *policy.mutable_taps()) {
    tap.set_value("mean");
    tap.clear_gaussian();
  }
  auto& parameters = *content.graph.mutable_parameters();
  EXPECT_EQ(parameters[parameters.size() - 1].name(), "policy/std");
  parameters.RemoveLast();
  content.weights.erase("policy/std");
  if (edit) edit(policy);
  const std::string directory = JoinPath(toy.folder, name);
  EXPECT_THAT(bundle::WriteBundle(content, directory), IsOk());
  return directory;
}

TEST(InitialPolicy, TakesAStudentWhichDoesNotExplore) {
  const NewRun run(SmallRecipe());
  const std::string student = WriteStudent("student");
  const auto bundle = bundle::ReadBundle(student);
  ASSERT_THAT(bundle, IsOk());
  ASSERT_FALSE(bundle->weights.contains("policy/std"));
  const TensorMap before = run.learner->weights();

  ASSERT_THAT(run.Begin({.init = student, .primitives = {}}), IsOk());

  const TensorMap weights = run.learner->weights();
  for (const auto& [name, tensor] : bundle->weights) {
    EXPECT_EQ(weights.at(name).data, tensor.data) << name;
  }
  // Exploration is the recipe's.
  EXPECT_EQ(weights.at("policy/std").data, before.at("policy/std").data);
}

TEST(InitialPolicy, TakesAPolicyOfNarrowerLayers) {
  v1::Recipe wide = SmallRecipe();
  wide.mutable_network()->set_policy_hidden(0, 11);
  const NewRun run(wide);
  const std::string narrow = WriteToy("narrow");
  const auto bundle = bundle::ReadBundle(narrow);
  ASSERT_THAT(bundle, IsOk());

  ASSERT_THAT(run.Begin({.init = narrow, .primitives = {}}), IsOk());

  const HostTensor taken = run.learner->weights().at("policy/linear_0/bias");
  const HostTensor given = bundle->weights.at("policy/linear_0/bias");
  ASSERT_EQ(taken.num_elements(), 11);
  ASSERT_EQ(given.num_elements(), 8);
  EXPECT_TRUE(absl::StartsWith(taken.data, given.data));
}

TEST(InitialPolicy, TakesAStudentForAPrimitive) {
  const NewRun run;
  const std::string student = WriteStudent("primitive");

  EXPECT_THAT(run.Begin({.init = "", .primitives = {student, student}}),
              IsOk());
}

TEST(InitialPolicy, RefusesAStudentThatDoesSomethingToItsMean) {
  const std::string clamps = WriteStudent("clamps", [](v1::Graph& policy) {
    v1::Node& node = *policy.add_nodes();
    node.set_name("clamped");
    node.set_op(v1::OP_CLAMP);
    node.add_inputs("mean");
    node.set_low(-1);
    node.set_high(1);
    for (v1::Tap& tap : *policy.mutable_taps()) {
      if (tap.name() == "action") tap.set_value("clamped");
    }
  });

  EXPECT_THAT(NewRun(SmallRecipe()).Begin({.init = clamps, .primitives = {}}),
              StatusIs(kInvalid, AllOf(HasSubstr(clamps), HasSubstr("nodes"))));
}

TEST(InitialPolicy, TakesTheValueNetworkThatComesWithABundle) {
  const NewRun run(SmallRecipe());
  const std::string bundle = WriteToy("bundle");
  const std::string name = "critic/linear_0/weight";
  HostTensor given = run.learner->weights().at(name);
  for (float& value : given.mutable_float32()) value = 0.25f;

  ASSERT_THAT(
      run.Begin({.init = bundle, .primitives = {}, .critic = {{name, given}}}),
      IsOk());

  EXPECT_EQ(run.learner->weights().at(name).data, given.data);
}

TEST(InitialPolicy, RefusesAnotherNumberOfPrimitives) {
  const std::string one = WriteToy("one");

  EXPECT_THAT(NewRun().Begin({}),
              StatusIs(kInvalid,
                       AllOf(HasSubstr("network.composer"),
                             HasSubstr("expected the bundles of 2 primitives"),
                             HasSubstr("found 0"))));
  EXPECT_THAT(NewRun().Begin({.init = "", .primitives = {one}}),
              StatusIs(kInvalid, HasSubstr("found 1")));
  EXPECT_THAT(
      NewRun(SmallRecipe()).Begin({.init = "", .primitives = {one, one}}),
      StatusIs(kInvalid, HasSubstr("of 0 primitives")));
  EXPECT_THAT(NewRun().Begin({.init = one, .primitives = {one, one}}),
              StatusIs(kInvalid, HasSubstr("found both")));
}

TEST(InitialPolicy, NamesBundleAndFieldOfAPrimitiveThatDoesNotFit) {
  struct Case {
    std::string name;
    std::function<void(v1::Recipe&)> edit;
    std::string field;
  };
  const std::vector<Case> cases = {
      {"composer",
       [](v1::Recipe& r) { *r.mutable_network() = ComposerRecipe().network(); },
       "found a composer"},
      {"observation",
       [](v1::Recipe& r) {
         r.mutable_task()->mutable_observation()->add_blocks(
             v1::Observation::BLOCK_PREVIOUS_TARGET);
       },
       "observation: expected the recipe's"},
      {"action",
       [](v1::Recipe& r) {
         r.mutable_task()->mutable_action()->set_scale(0.7);
       },
       "action: expected the recipe's"},
      {"rate", [](v1::Recipe& r) { r.mutable_physics()->set_control_hz(60); },
       "control_hz: expected 30, found 60"},
      {"activation",
       [](v1::Recipe& r) {
         r.mutable_network()->set_activation(v1::Network::ACTIVATION_TANH);
       },
       "node hidden_0_activation"},
      {"clip",
       [](v1::Recipe& r) { r.mutable_network()->set_observation_clip(5); },
       "node clipped"},
      {"width",
       [](v1::Recipe& r) { r.mutable_network()->set_policy_hidden(0, 9); },
       "network.policy_hidden): shape: expected [8, 68], found [9, 68]"},
      {"narrower",
       [](v1::Recipe& r) { r.mutable_network()->set_policy_hidden(0, 7); },
       "network.policy_hidden): shape: expected [8, 68], found [7, 68]"},
      {"depth",
       [](v1::Recipe& r) { r.mutable_network()->add_policy_hidden(8); },
       "network.policy_hidden): expected"},
  };
  const NewRun run;
  const std::string good = WriteToy("good");
  for (const Case& one : cases) {
    const std::string bad = WriteToy(one.name, one.edit);

    EXPECT_THAT(
        run.Begin({.init = "", .primitives = {good, bad}}),
        StatusIs(kInvalid, AllOf(HasSubstr(bad), HasSubstr(one.field))));
  }
}

TEST(InitialPolicy, RefusesABundleOfAnotherCharacterOrObservation) {
  const NewRun run(SmallRecipe());
  const std::string humanoid = JoinPath(::testing::TempDir(), "humanoid");
  ASSERT_THAT(bundle::WriteBundle(
                  bundle::testing::CharacterContent("humanoid", SmallRecipe()),
                  humanoid),
              IsOk());
  const std::string other = WriteToy("other", [](v1::Recipe& recipe) {
    recipe.mutable_task()->mutable_observation()->add_frames_ahead(3);
  });

  EXPECT_THAT(run.Begin({.init = humanoid, .primitives = {}}),
              StatusIs(kInvalid,
                       AllOf(HasSubstr(humanoid),
                             HasSubstr("character: expected \"toy\", found"))));
  EXPECT_THAT(NewRun().Begin({.init = "", .primitives = {humanoid, humanoid}}),
              StatusIs(kInvalid, HasSubstr("character: expected \"toy\"")));
  EXPECT_THAT(run.Begin({.init = other, .primitives = {}}),
              StatusIs(kInvalid, AllOf(HasSubstr(other),
                                       HasSubstr("observation: expected"))));
}

TEST(InitialPolicy, RefusesAnInitThatActsByAnotherLawOrAtAnotherRate) {
  struct Case {
    std::string name;
    std::function<void(v1::Recipe&)> edit;
    std::string field;
  };
  const std::vector<Case> cases = {
      {"init_action",
       [](v1::Recipe& r) {
         r.mutable_task()->mutable_action()->set_scale(0.7);
       },
       "action: expected the recipe's"},
      {"init_rate",
       [](v1::Recipe& r) { r.mutable_physics()->set_control_hz(60); },
       "control_hz: expected 30, found 60"},
  };
  for (const v1::Recipe& recipe : {SmallRecipe(), ComposerRecipe()}) {
    const NewRun run(recipe);
    const TensorMap before = run.learner->weights();
    for (const Case& one : cases) {
      const std::string bad = WriteToy(one.name, [&](v1::Recipe& r) {
        *r.mutable_network() = recipe.network();
        one.edit(r);
      });

      EXPECT_THAT(
          run.Begin({.init = bad, .primitives = {}}),
          StatusIs(kInvalid, AllOf(HasSubstr(bad), HasSubstr(one.field))));
    }
    for (const auto& [name, tensor] : run.learner->weights()) {
      EXPECT_EQ(tensor.data, before.at(name).data) << name;
    }
  }
}

TEST(InitialPolicy, RefusesAnotherOrderOfJointsAndAnotherDigest) {
  const std::string bundle = WriteToy("bundle");
  NewRun reversed, edited;
  std::reverse(reversed.setup.joints.begin(), reversed.setup.joints.end());
  edited.setup.character_sha256 = std::string(64, '0');

  EXPECT_THAT(
      reversed.Begin({.init = "", .primitives = {bundle, bundle}}),
      StatusIs(kInvalid, AllOf(HasSubstr(bundle), HasSubstr("joints: "))));
  EXPECT_THAT(edited.Begin({.init = "", .primitives = {bundle, bundle}}),
              StatusIs(kInvalid, HasSubstr("character_sha256: expected 000")));
}

TEST(InitialPolicy, SaysThatABundleIsNotThere) {
  EXPECT_THAT(
      NewRun(SmallRecipe()).Begin({.init = "/nowhere", .primitives = {}}),
      StatusIs(absl::StatusCode::kNotFound, HasSubstr("/nowhere")));
}

}  // namespace
}  // namespace sinew::tools
