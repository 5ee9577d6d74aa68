// Prints how fast PPO updates run, beside the plain matrix products of the same
// library in the same run:
//
//   bazel run --config=opt //tools/bench:learner_benchmark -- [updates]
//
// and what replay costs. Run it on an idle machine.
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "tools/bench/learner_figures.h"
#include "tools/bench/transport_figures.h"

namespace {

// The humanoid's widths.
constexpr int kObservation = 224;
constexpr int kAction = 28;

sinew::v1::Recipe MakeRecipe(const std::vector<int>& hidden, int minibatch) {
  sinew::v1::Recipe recipe;
  recipe.set_format_version(1);
  recipe.set_name("benchmark");
  for (const int width : hidden) {
    recipe.mutable_network()->add_policy_hidden(width);
    recipe.mutable_network()->add_value_hidden(width);
  }
  recipe.mutable_ppo()->set_minibatch(minibatch);
  return recipe;
}

void PrintLearner(const std::vector<int>& hidden, int minibatch, int updates) {
  const auto ratios = sinew::bench::MeasureLearner(
      MakeRecipe(hidden, minibatch),
      {.observation = kObservation, .action = kAction}, updates);
  if (!ratios.ok()) {
    std::printf("%s\n", ratios.status().ToString().c_str());
    return;
  }
  std::printf("%4d-%-5d %9d %11.0f %9.1f %9.1f %6.3f %6.3f %8.2f ", hidden[0],
              hidden[1], minibatch, ratios->one_rank.samples_per_s,
              ratios->one_rank.flops_per_s * 1e-9,
              ratios->gemm_flops_per_s * 1e-9, ratios->gemm_ratio,
              ratios->cpu_gemm_ratio, ratios->two_ranks_ratio);
  if (ratios->bfloat16_ratio.has_value()) {
    std::printf("%6.2f\n", *ratios->bfloat16_ratio);
  } else {
    std::printf("%6s\n", "none");
  }
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const int updates = argc > 1 ? std::atoi(argv[1]) : 12;
  std::printf("%-10s %9s %11s %9s %9s %6s %6s %8s %6s\n", "hidden", "minibatch",
              "samples/s", "GFLOP/s", "product", "ratio", "cpu", "2 ranks",
              "bf16");
  for (const std::vector<int>& hidden :
       {std::vector<int>{512, 256}, std::vector<int>{256, 256}}) {
    for (const int minibatch : {4096, 2048}) {
      PrintLearner(hidden, minibatch, updates);
    }
  }
  const auto transport = sinew::bench::MeasureTransport({});
  if (!transport.ok()) {
    std::printf("%s\n", transport.status().ToString().c_str());
    return 1;
  }
  std::printf(
      "transport: %.2f GB/s, %.2f core seconds per GB, %.0f bytes per sample, "
      "%.4f of a core at 10000 samples/s\n",
      transport->gb_per_s, transport->core_s_per_gb,
      transport->bytes_per_sample, transport->core_share);
  return 0;
}
