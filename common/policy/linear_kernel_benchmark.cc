// Speed of linear layers and whole policies on one core, beside the core's
// peak of fused multiply-adds measured in the same run:
//
//   bazel run --config=opt //common/policy:linear_kernel_benchmark
//
// "gflops" counts two operations for each multiply-add of real rows.
#include <vector>

#include "benchmark/benchmark.h"
#include "common/check.h"
#include "common/policy/builder.h"
#include "common/policy/executor.h"
#include "common/policy/linear_kernel.h"
#include "common/policy/vector_math.h"

namespace sinew::policy::internal {
namespace {

void SetGflops(benchmark::State& state, double per_iteration) {
  state.counters["gflops"] = benchmark::Counter(
      per_iteration * 1e-9, benchmark::Counter::kIsIterationInvariantRate);
}

// Ten independent chains: more than latency times ports, no memory.
void BM_PeakMultiplyAdd(benchmark::State& state) {
  constexpr int kChains = 10;
  constexpr int kLength = 1000;
  Float8 sums[kChains];
  for (int c = 0; c < kChains; ++c) sums[c] = Splat(static_cast<float>(c));
  const Float8 a = Splat(0.999f);
  const Float8 b = Splat(0.001f);
  for (auto _ : state) {
    for (int i = 0; i < kLength; ++i) {
#pragma clang loop unroll(full)
      for (int c = 0; c < kChains; ++c) sums[c] = Fma(sums[c], a, b);
    }
    for (int c = 0; c < kChains; ++c) benchmark::DoNotOptimize(sums[c]);
  }
  SetGflops(state, 2.0 * kLanes * kChains * kLength);
}
BENCHMARK(BM_PeakMultiplyAdd);

// Arguments: inputs, outputs, rows.
void BM_Linear(benchmark::State& state) {
  const int64_t k = state.range(0);
  const int64_t n = state.range(1);
  const int64_t rows = RoundUp(state.range(2), kRowBlock);
  const std::vector<float> weight(n * k, 0.01f);
  const AlignedBuffer panels = PackPanels(weight, n, k);
  const AlignedBuffer bias(RoundUp(n, kPanel));
  AlignedBuffer x(rows * RoundUp(k, kPanel));
  AlignedBuffer y(rows * RoundUp(n, kPanel));
  for (int64_t i = 0; i < rows * RoundUp(k, kPanel); ++i) x.data()[i] = 0.5f;
  for (auto _ : state) {
    Linear({.rows = rows,
            .k = k,
            .n = n,
            .x_stride = RoundUp(k, kPanel),
            .y_stride = RoundUp(n, kPanel)},
           x.data(), panels.data(), bias.data(), y.data());
    benchmark::ClobberMemory();
  }
  SetGflops(state, 2.0 * k * n * state.range(2));
}
BENCHMARK(BM_Linear)
    ->Args({256, 256, 1})
    ->Args({256, 256, 8})
    ->Args({256, 256, 64})
    ->Args({512, 256, 8})
    ->Args({512, 256, 64})
    ->Args({224, 512, 8})
    ->Args({224, 512, 64})
    ->Args({256, 28, 8});

// The default policy: 224 - 256 - 256 - 28 with SiLU. Argument: rows.
void BM_Policy(benchmark::State& state) {
  TrackingPolicyOptions options{.observation_width = 224, .action_width = 28};
  for (int i = 0; i < 2; ++i) {
    options.network.add_policy_hidden(256);
    options.network.add_value_hidden(256);
  }
  options.network.set_activation(v1::Network::ACTIVATION_SILU);
  options.network.set_last_layer_gain(0.01);
  options.network.set_observation_clip(8);
  options.network.set_initial_std(0.4);
  const auto graph = BuildTrackingPolicy(options);
  const auto weights = InitialWeights(options, 1);
  SINEW_CHECK(graph.ok() && weights.ok());
  const int rows = static_cast<int>(state.range(0));
  auto executor =
      *Executor::Create(*PackWeights(*graph, "policy", *weights), rows);
  for (float& value : executor->input(0)) value = 0.5f;
  for (auto _ : state) executor->Run(rows);
  SetGflops(state, 2.0 * rows * (224 * 256 + 256 * 256 + 256 * 28));
}
BENCHMARK(BM_Policy)->Arg(1)->Arg(8)->Arg(64);

}  // namespace
}  // namespace sinew::policy::internal

BENCHMARK_MAIN();
