#include "learner/torch/trained_network.h"

#include <ATen/ATen.h>
#include <gmock/gmock.h>
#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/policy/safetensors.h"
#include "common/testing/matchers.h"
#include "proto/sinew/v1/graph.pb.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

// y = x * scale + shift, two numbers wide.
constexpr char kGraph[] = R"pb(
  format_version: 1
  graphs {
    name: "affine"
    inputs { name: "x" width: 2 kind: KIND_DATA }
    nodes {
      name: "y"
      op: OP_AFFINE
      inputs: "x"
      parameters: [ "scale", "shift" ]
    }
    taps { name: "y" value: "y" }
  }
  parameters { name: "scale" shape: 2 }
  parameters { name: "shift" shape: 2 }
)pb";

std::unique_ptr<TrainedNetwork> MakeNetwork() {
  v1::PolicyGraph graph;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(kGraph, &graph));
  auto network = TrainedNetwork::Create(
      graph, {.graph_name = "affine", .inputs = {"x"}, .outputs = {"y"}},
      std::vector<at::Tensor>{at::zeros({2}), at::zeros({2})}, at::kCPU);
  EXPECT_THAT(network, IsOk());
  return *std::move(network);
}

// One step on the loss sum(pull * y) at x = (2, -3): its gradient is pull * x
// for the scale and pull for the shift.
void Step(TrainedNetwork& network, std::array<float, 2> pull, double rate,
          double gradient_scale) {
  const at::Tensor x = at::tensor({2.F, -3.F}).view({1, 2});
  const at::Tensor y = network.ForwardInputs(0, {x})[0];
  network.Gradient(0, (y * at::tensor({pull[0], pull[1]})).sum());
  network.SumGradients();
  network.Step(rate, gradient_scale);
}

std::vector<double> Weights(const TrainedNetwork& network) {
  std::vector<double> weights;
  for (const at::Tensor& view : network.weights().Views()) {
    for (int64_t i = 0; i < view.numel(); ++i) {
      weights.push_back(view[i].item<double>());
    }
  }
  return weights;
}

// Adam in doubles (Kingma and Ba, 2015, algorithm 1).
class Adam {
 public:
  void Step(const std::array<double, 4>& gradient, double rate) {
    ++steps;
    for (size_t i = 0; i < 4; ++i) {
      first[i] = 0.9 * first[i] + 0.1 * gradient[i];
      second[i] = 0.999 * second[i] + 0.001 * gradient[i] * gradient[i];
      const double mean = first[i] / (1 - std::pow(0.9, steps));
      const double square = second[i] / (1 - std::pow(0.999, steps));
      weight[i] -= rate * mean / (std::sqrt(square) + 1e-8);
    }
  }

  int steps = 0;
  std::array<double, 4> weight{}, first{}, second{};
};

void ExpectSame(const TrainedNetwork& network, const Adam& adam) {
  const std::vector<double> weights = Weights(network);
  ASSERT_EQ(weights.size(), 4);
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(weights[i], adam.weight[i], 2e-6 * std::abs(adam.weight[i]))
        << i;
  }
  EXPECT_EQ(network.steps(), adam.steps);
}

TEST(TrainedNetwork, StepsAsAdamDoes) {
  const auto network = MakeNetwork();
  Adam adam;

  // The last gradient is halved, as where its norm is clipped.
  Step(*network, {1, 0.5}, 1e-2, 1);
  adam.Step({2, -1.5, 1, 0.5}, 1e-2);
  Step(*network, {-3, 0.01}, 1e-2, 1);
  adam.Step({-6, -0.03, -3, 0.01}, 1e-2);
  Step(*network, {0.25, 4}, 3e-3, 0.5);
  adam.Step({0.25, -6, 0.125, 2}, 3e-3);

  ExpectSame(*network, adam);
}

TEST(TrainedNetwork, GoesOnFromMomentsAndTheirSteps) {
  const auto network = MakeNetwork();
  Adam adam;
  adam.steps = 7;
  adam.first = {0.5, -0.25, 1, 0};
  adam.second = {4, 0.5, 0.001, 1};
  TensorMap moments;
  const auto put = [&](const char* name, float a, float b) {
    moments[name] = HostTensor::Float32({2}, {a, b});
  };
  put("adam/first_moment/scale", 0.5, -0.25);
  put("adam/first_moment/shift", 1, 0);
  put("adam/second_moment/scale", 4, 0.5);
  put("adam/second_moment/shift", 0.001, 1);

  ASSERT_THAT(network->LoadMoments(moments, 7), IsOk());
  Step(*network, {1, 0.5}, 1e-2, 1);
  adam.Step({2, -1.5, 1, 0.5}, 1e-2);

  ExpectSame(*network, adam);
  TensorMap saved;
  network->SaveMoments(saved);
  EXPECT_NEAR(saved.at("adam/first_moment/scale").float32()[0], adam.first[0],
              1e-6);
  EXPECT_NEAR(saved.at("adam/second_moment/shift").float32()[1], adam.second[3],
              1e-6);
}

TEST(TrainedNetwork, NamesAMomentThatIsMissing) {
  EXPECT_THAT(MakeNetwork()->LoadMoments({}, 7),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("adam/first_moment/scale")));
}

}  // namespace
}  // namespace sinew::learner
