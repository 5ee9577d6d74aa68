// Prints how much of an actor's time is physics, by threads:
//
//   bazel run --config=opt //tools/bench:actor_benchmark -- LIBRARY [rounds]
//
// LIBRARY is a motion library of the humanoid; the recipe is all defaults but
// for the default policy's 256, 256. `sinew bench` writes the same figures.
#include <cstdio>
#include <cstdlib>
#include <string>

#include "absl/status/status.h"
#include "common/config/recipe.h"
#include "common/status_macros.h"
#include "sim/character/character.h"
#include "sim/motion/library.h"
#include "tools/bench/actor_figures.h"

namespace {

absl::Status Run(const std::string& directory, int rounds) {
  sinew::v1::Recipe recipe;
  recipe.set_format_version(1);
  for (int i = 0; i < 2; ++i) recipe.mutable_network()->add_policy_hidden(256);
  recipe.mutable_task()->mutable_action()->set_velocity_feedforward(true);
  recipe.mutable_task()->mutable_action()->set_torque_feedforward(true);
  recipe.mutable_task()->mutable_action()->set_ramp(true);
  recipe = sinew::WithDefaults(recipe);
  SINEW_ASSIGN_OR_RETURN(auto character, sinew::character::Character::Load(
                                             "humanoid", recipe.physics()));
  SINEW_ASSIGN_OR_RETURN(auto library, sinew::motion::Library::Load(directory));
  SINEW_RETURN_IF_ERROR(library->Verify());
  SINEW_ASSIGN_OR_RETURN(const auto assets,
                         sinew::actor::RolloutAssets::FromParts(
                             recipe, std::move(character), std::move(library)));
  SINEW_ASSIGN_OR_RETURN(const auto snapshot,
                         sinew::bench::IdlePolicy(*assets));
  std::printf("threads  ratio  raw/s  step us  other us  products us\n");
  for (int threads : {1, 2}) {
    SINEW_ASSIGN_OR_RETURN(
        const auto figures,
        sinew::bench::MeasureActor({.threads = threads, .rounds = rounds},
                                   assets, snapshot));
    std::printf("%7d %6.3f %6.0f %8.1f %9.2f %12.2f\n", threads, figures.ratio,
                figures.raw_steps_per_s, figures.step_us, figures.other_us,
                figures.products_us);
  }
  return absl::OkStatus();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: actor_benchmark LIBRARY [rounds]\n");
    return 2;
  }
  const absl::Status status = Run(argv[1], argc > 2 ? std::atoi(argv[2]) : 6);
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.ToString().c_str());
  return status.ok() ? 0 : 1;
}
