// What a policy with a latent begins with.

#include <cmath>
#include <string>

#include "common/policy/latent_builder.h"
#include "common/policy/safetensors.h"
#include "common/policy/testing/latent_rig.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::policy {
namespace {

using ::testing::Each;
using testing::kAction;
using testing::kLatent;
using testing::kObservation;
using testing::SmallOptions;

TEST(LatentWeights, InitialWeightsAreAFunctionOfTheSeed) {
  const auto one = *InitialLatentWeights(SmallOptions(), 7);

  EXPECT_EQ(SerializeSafetensors(one),
            SerializeSafetensors(*InitialLatentWeights(SmallOptions(), 7)));
  EXPECT_NE(SerializeSafetensors(one),
            SerializeSafetensors(*InitialLatentWeights(SmallOptions(), 8)));
  EXPECT_THAT(one.at("normaliser/goal/inverse_std").float32(), Each(1));
  EXPECT_THAT(one.at("latent/half").float32(), Each(0.5f));
  EXPECT_THAT(one.at("decoder/action/bias").float32(), Each(0));
}

TEST(LatentWeights, GainsAreThoseOfTheHeader) {
  const auto weights = *InitialLatentWeights(SmallOptions(), 7);
  const auto norm = [&](const std::string& name) {
    double squares = 0;
    for (const float w : weights.at(name).float32()) squares += w * w;
    return std::sqrt(squares);
  };

  // As many orthonormal vectors as the shorter side has.
  EXPECT_NEAR(norm("encoder/linear_0/weight"), std::sqrt(2.0 * kObservation),
              1e-5);
  EXPECT_NEAR(norm("encoder/mean/weight"), 0.3 * std::sqrt(kLatent), 1e-5);
  EXPECT_NEAR(norm("prior/log_variance/weight"), 0.3 * std::sqrt(kLatent),
              1e-5);
  EXPECT_NEAR(norm("decoder/action/weight"), 0.3 * std::sqrt(kAction), 1e-5);
}

}  // namespace
}  // namespace sinew::policy
