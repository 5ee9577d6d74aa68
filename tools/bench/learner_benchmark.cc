// Prints how fast PPO updates run, beside the plain matrix products of the same
// library in the same run:
//
//   bazel run --config=opt //tools/bench:learner_benchmark -- [updates]
//
// learner.gemm_ratio is the first line's ratio; two ranks against one is the
// quotient of samples/s. Run it on an idle machine.
#include <cstdio>
#include <cstdlib>
#include <initializer_list>
#include <vector>

#include "tools/bench/learner_figures.h"

namespace {

sinew::v1::Recipe MakeRecipe(const std::vector<int>& hidden, int minibatch,
                             bool bfloat16) {
  sinew::v1::Recipe recipe;
  recipe.set_format_version(1);
  recipe.set_name("benchmark");
  for (const int width : hidden) {
    recipe.mutable_network()->add_policy_hidden(width);
    recipe.mutable_network()->add_value_hidden(width);
  }
  recipe.mutable_ppo()->set_minibatch(minibatch);
  recipe.mutable_ppo()->set_bfloat16(bfloat16);
  return recipe;
}

}  // namespace

int main(int argc, char** argv) {
  const int updates = argc > 1 ? std::atoi(argv[1]) : 12;
  // The humanoid's widths.
  constexpr int kObservation = 224;
  constexpr int kAction = 28;
  std::printf("%-10s %9s %5s %5s %11s %9s %9s %6s %6s\n", "hidden", "minibatch",
              "type", "ranks", "samples/s", "GFLOP/s", "product", "ratio",
              "cpu");
  for (const std::vector<int>& hidden :
       {std::vector<int>{256, 256}, std::vector<int>{512, 256}}) {
    for (const int minibatch : {4096, 2048}) {
      for (const bool bfloat16 : {false, true}) {
        for (const int ranks : {1, 2}) {
          const auto figures = sinew::bench::MeasureLearner(
              MakeRecipe(hidden, minibatch, bfloat16), kObservation, kAction,
              ranks, updates);
          if (!figures.ok()) {
            if (ranks == 1)
              std::printf("%s\n", figures.status().ToString().c_str());
            continue;
          }
          std::printf("%4d-%-5d %9d %5s %5d %11.0f %9.1f %9.1f %6.3f %6.3f\n",
                      hidden[0], hidden[1], minibatch,
                      bfloat16 ? "bf16" : "f32", ranks, figures->samples_per_s,
                      figures->flops_per_s * 1e-9,
                      figures->gemm_flops_per_s * 1e-9, figures->gemm_ratio,
                      figures->cpu_gemm_ratio);
          std::fflush(stdout);
        }
      }
    }
  }
  return 0;
}
