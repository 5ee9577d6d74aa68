#include <ATen/ATen.h>
#include <dlfcn.h>

#include <atomic>
#include <cstdlib>

#include "gtest/gtest.h"
#include "learner/torch/runtime.h"

namespace {

std::atomic<int> finished_calls = 0;

}  // namespace

// Stands before the function of this name that libtorch brings, MKL's exp.
extern "C" void vmsExp(int count, const float* in, float* out, long long mode) {
  using Function = void (*)(int, const float*, float*, long long);
  static const auto libtorchs =
      reinterpret_cast<Function>(dlsym(RTLD_NEXT, "vmsExp"));
  if (libtorchs == nullptr) std::abort();  // libtorch has none of that name
  libtorchs(count, in, out, mode);
  ++finished_calls;
}

namespace sinew::learner {
namespace {

// Whoever has called UseOneThread computes after the first call of the process.
TEST(RuntimeFirstCall, IsMadeBeforeThereAreThreadsThatCompute) {
  EXPECT_EQ(finished_calls, 0);

  UseOneThread();

  const int before = finished_calls;
  EXPECT_GE(before, 1);
  const at::Tensor one = at::exp(at::zeros({1}, at::kFloat));
  EXPECT_EQ(one.item<float>(), 1);
  // Else libtorch computes exp by other means, and the first call that
  // UseOneThread makes is of no use.
  EXPECT_GT(finished_calls, before);
}

}  // namespace
}  // namespace sinew::learner
