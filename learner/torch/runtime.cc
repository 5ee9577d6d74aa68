#include "learner/torch/runtime.h"

#include <ATen/ATen.h>
#include <ATen/Context.h>
#include <ATen/Parallel.h>
#include <cpuid.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <mutex>

#include "absl/strings/str_cat.h"

namespace sinew::learner {
namespace {

// Seconds of the fastest of a few runs.
double BestSeconds(const at::Tensor& out, const at::Tensor& a,
                   const at::Tensor& b) {
  constexpr int kRuns = 6;
  double best = std::numeric_limits<double>::infinity();
  for (int run = 0; run < kRuns; ++run) {
    const auto begin = std::chrono::steady_clock::now();
    at::mm_out(const_cast<at::Tensor&>(out), a, b);
    const std::chrono::duration<double> seconds =
        std::chrono::steady_clock::now() - begin;
    best = std::min(best, seconds.count());
  }
  return best;
}

}  // namespace

void UseOneThread() {
  static std::once_flag once;
  std::call_once(once, [] {
    try {
      at::set_num_interop_threads(1);
    } catch (const c10::Error&) {
      // Somebody started libtorch's other pool before: nothing here uses it.
    }
    // exp, log, sqrt and tanh are MKL's, which at its first call stores twice
    // what CPU this is: a thread that calls in between gets numbers of another
    // kernel, 1e-4 off (pytorch issue 188792). So that call is made here.
    at::exp(at::zeros({1}, at::kFloat));
  });
  at::set_num_threads(1);
  at::globalContext().setFlushDenormal(true);
}

absl::Status CheckDevice(const std::string& device) {
  if (device.empty() || device == "cpu") return absl::OkStatus();
  if (device != "cuda") {
    return absl::InvalidArgumentError(absl::StrCat(
        "recipe field device: expected \"cpu\" or \"cuda\", found \"", device,
        "\""));
  }
  if (!at::globalContext().hasCUDA()) {
    return absl::FailedPreconditionError(
        "recipe field device: asked for \"cuda\", found no CUDA device (this "
        "build of libtorch has no CUDA, or the driver shows none)");
  }
  return absl::OkStatus();
}

CpuFeatures DetectCpu() {
  CpuFeatures features;
  unsigned a = 0, b = 0, c = 0, d = 0;
  if (__get_cpuid_count(7, 0, &a, &b, &c, &d)) {
    features.amx_bf16 = d & (1u << 22);
  }
  if (__get_cpuid_count(7, 1, &a, &b, &c, &d)) {
    features.avx512_bf16 = a & (1u << 5);
  }
  return features;
}

absl::Status CheckBfloat16(const CpuFeatures& cpu, const std::string& device,
                           absl::string_view field) {
  if (device == "cuda" || cpu.avx512_bf16 || cpu.amx_bf16) {
    return absl::OkStatus();
  }
  return absl::FailedPreconditionError(
      absl::StrCat("recipe field ", field,
                   ": asked for bfloat16 products, found a CPU with "
                   "neither avx512_bf16 nor amx_bf16"));
}

double PlainMatmulFlops() {
  double best = 0;
  for (const int64_t width : {256, 512, 1024}) {
    for (const int64_t rows : {1024, 4096}) {
      const at::Tensor a = at::rand({rows, width}, at::kFloat);
      const at::Tensor b = at::rand({width, width}, at::kFloat);
      const at::Tensor out = at::empty({rows, width}, at::kFloat);
      const double flops = 2.0 * static_cast<double>(rows * width * width);
      best = std::max(best, flops / BestSeconds(out, a, b));
      best = std::max(best, flops / BestSeconds(out, a, b.t()));
    }
  }
  return best;
}

}  // namespace sinew::learner
