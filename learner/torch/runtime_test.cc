#include "learner/torch/runtime.h"

#include "absl/status/status.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

TEST(Runtime, KnowsTheCpu) {
  EXPECT_THAT(CheckDevice(""), IsOk());
  EXPECT_THAT(CheckDevice("cpu"), IsOk());
}

TEST(Runtime, RefusesAnUnknownDeviceByName) {
  EXPECT_THAT(
      CheckDevice("tpu"),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("expected \"cpu\" or \"cuda\", found \"tpu\"")));
}

TEST(Runtime, RefusesBfloat16WhereTheCpuLacksIt) {
  EXPECT_THAT(CheckBfloat16({}, "cpu"),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("neither avx512_bf16 nor amx_bf16")));
  EXPECT_THAT(CheckBfloat16({.avx512_bf16 = true}, "cpu"), IsOk());
  EXPECT_THAT(CheckBfloat16({.amx_bf16 = true}, "cpu"), IsOk());
  EXPECT_THAT(CheckBfloat16({}, "cuda"), IsOk());
}

}  // namespace
}  // namespace sinew::learner
