// What a run that learns a latent may begin with.
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "common/config/recipe.h"
#include "common/files.h"
#include "common/policy/latent_builder.h"
#include "common/policy/safetensors.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_latent.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "sim/world/testing/toy_world.h"
#include "tools/training/initial_policy.h"
#include "tools/training/testing/new_run.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::NewRun;

constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;

// A latent that PPO learns; widths of the prior's hidden layers.
v1::Recipe LatentRecipe(const std::vector<int>& prior_hidden) {
  v1::Recipe recipe = bundle::testing::ToyLatentRecipe();
  recipe.mutable_network()->Clear();
  recipe.mutable_network()->add_value_hidden(8);
  v1::Latent& latent = *recipe.mutable_network()->mutable_latent();
  latent.set_width(6);
  latent.add_encoder_hidden(8);
  latent.add_decoder_hidden(8);
  for (const int width : prior_hidden) latent.add_prior_hidden(width);
  return WithDefaults(recipe);
}

// A bundle of the policy that such a run begins with.
std::string WriteLatent(const NewRun& run, const std::string& name) {
  const world::testing::ToyWorld toy = world::testing::MakeToyWorld(run.recipe);
  bundle::BundleContent content = bundle::testing::ToyLatentContent(toy);
  content.graph = run.learner->graph();
  auto& graphs = *content.graph.mutable_graphs();
  for (int i = 0; i < graphs.size(); ++i) {
    if (graphs[i].name() != "critic") continue;
    graphs.DeleteSubrange(i, 1);
    break;
  }
  content.weights = run.learner->weights();
  const std::string directory = JoinPath(toy.folder, name);
  EXPECT_THAT(bundle::WriteBundle(content, directory), IsOk());
  return directory;
}

TEST(InitialLatent, TakesTheSamePriorAndRefusesOneOfOtherLayers) {
  const NewRun run(LatentRecipe({8}));
  const std::string same = WriteLatent(NewRun(LatentRecipe({8})), "same");
  const std::string deep = WriteLatent(NewRun(LatentRecipe({8, 8})), "deep");
  const std::string wide = WriteLatent(NewRun(LatentRecipe({9})), "wide");

  EXPECT_THAT(run.Begin({.init = same, .primitives = {}}), IsOk());
  EXPECT_THAT(
      run.Begin({.init = deep, .primitives = {}}),
      StatusIs(kInvalid,
               AllOf(HasSubstr(deep),
                     HasSubstr("graph prior (network.latent.prior_hidden): "
                               "expected"))));
  EXPECT_THAT(
      run.Begin({.init = wide, .primitives = {}}),
      StatusIs(kInvalid, AllOf(HasSubstr(wide),
                               HasSubstr("network.latent.prior_hidden"))));
}

TEST(InitialLatent, TakesAStudentsLatentForOneThatPpoLearns) {
  const NewRun run(LatentRecipe({8}));
  // As a distillation begins: the same networks, drawn anew, no exploration.
  const policy::LatentPolicyOptions options = {
      .self_observation_width = run.setup.self_observation_width,
      .observation_width = run.setup.observation_width,
      .action_width = run.setup.action_width,
      .network = run.recipe.network()};
  const auto graph = policy::BuildLatentPolicy(options);
  ASSERT_THAT(graph, IsOk());
  const auto weights = policy::InitialLatentWeights(options, /*seed=*/77);
  ASSERT_THAT(weights, IsOk());
  const world::testing::ToyWorld toy = world::testing::MakeToyWorld(run.recipe);
  bundle::BundleContent content = bundle::testing::ToyLatentContent(toy);
  content.graph = *graph;
  content.weights = *weights;
  const std::string student = JoinPath(toy.folder, "latent_student");
  ASSERT_THAT(bundle::WriteBundle(content, student), IsOk());

  ASSERT_THAT(run.Begin({.init = student, .primitives = {}}), IsOk());

  const TensorMap taken = run.learner->weights();
  for (const auto& [name, tensor] : *weights) {
    EXPECT_EQ(taken.at(name).data, tensor.data) << name;
  }
}

}  // namespace
}  // namespace sinew::tools
