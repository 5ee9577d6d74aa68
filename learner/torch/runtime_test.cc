#include "learner/torch/runtime.h"

#include "absl/status/status.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
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
  EXPECT_THAT(CheckBfloat16({}, "cpu", "ppo.bfloat16"),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       AllOf(HasSubstr("recipe field ppo.bfloat16"),
                             HasSubstr("neither avx512_bf16 nor amx_bf16"))));
  EXPECT_THAT(CheckBfloat16({.avx512_bf16 = true}, "cpu", "ppo.bfloat16"),
              IsOk());
  EXPECT_THAT(CheckBfloat16({.amx_bf16 = true}, "cpu", "ppo.bfloat16"), IsOk());
  EXPECT_THAT(CheckBfloat16({}, "cuda", "ppo.bfloat16"), IsOk());
}

}  // namespace
}  // namespace sinew::learner
