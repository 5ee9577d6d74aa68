#include "learner/update/graph_normalisers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>

#include "common/policy/safetensors.h"
#include "learner/update/normaliser.h"

namespace sinew::learner {
namespace {

constexpr int kObservation = 6, kOwn = 4;

void AddNormaliser(const std::string& prefix, int64_t width,
                   TensorMap& weights) {
  weights[prefix + "/mean"] = HostTensor::Zeros({width});
  weights[prefix + "/inverse_std"] = HostTensor::Zeros({width});
}

TensorMap WithLatent() {
  TensorMap weights;
  AddNormaliser("normaliser/own", kOwn, weights);
  AddNormaliser("normaliser/goal", kObservation - kOwn, weights);
  return weights;
}

TensorMap WithoutLatent() {
  TensorMap weights;
  AddNormaliser("normaliser", kObservation, weights);
  // A composer's primitives have theirs as well.
  AddNormaliser("primitive_0/normaliser", kObservation, weights);
  return weights;
}

// Column j of 4 rows has mean j and variance j + 1.
Moments Different() {
  Moments moments(kObservation);
  moments.count = 4;
  for (int j = 0; j < kObservation; ++j) {
    moments.mean[j] = j;
    moments.squares[j] = 4 * (j + 1);
  }
  return moments;
}

TEST(GraphNormalisers, PutEachColumnIntoTheNormaliserThatSeesIt) {
  TensorMap weights = WithLatent();

  WriteNormalisers(Different(), weights);

  for (int j = 0; j < kObservation; ++j) {
    const std::string prefix = j < kOwn ? "normaliser/own" : "normaliser/goal";
    const int place = j < kOwn ? j : j - kOwn;
    EXPECT_EQ(weights.at(prefix + "/mean").float32()[place], j);
    EXPECT_NEAR(weights.at(prefix + "/inverse_std").float32()[place],
                1 / std::sqrt(j + 1.0), 1e-6);
  }
}

TEST(GraphNormalisers, PutAllColumnsIntoTheOnlyOne) {
  TensorMap weights = WithoutLatent();

  WriteNormalisers(Different(), weights);

  for (int j = 0; j < kObservation; ++j) {
    EXPECT_EQ(weights.at("normaliser/mean").float32()[j], j);
    EXPECT_EQ(weights.at("primitive_0/normaliser/mean").float32()[j], 0);
  }
}

TEST(GraphNormalisers, InheritTheColumnsInTheirOrder) {
  for (TensorMap weights : {WithLatent(), WithoutLatent()}) {
    WriteNormalisers(Different(), weights);

    Moments inherited(kObservation);
    InheritNormalisers(weights, /*count=*/10, inherited);

    EXPECT_EQ(inherited.count, 10);
    ASSERT_EQ(inherited.mean.size(), static_cast<size_t>(kObservation));
    ASSERT_EQ(inherited.squares.size(), static_cast<size_t>(kObservation));
    for (int j = 0; j < kObservation; ++j) {
      EXPECT_EQ(inherited.mean[j], j);
      EXPECT_NEAR(inherited.squares[j], 10 * (j + 1), 1e-4);
    }
  }
}

}  // namespace
}  // namespace sinew::learner
