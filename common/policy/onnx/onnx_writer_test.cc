#include "common/policy/onnx/onnx_writer.h"

#include <string>

#include "common/policy/testing/examples.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "onnx/onnx_pb.h"

// Whether the numbers are right is tested with an ONNX runtime in tools/parity.
namespace sinew::policy {
namespace {

using ::sinew::policy::testing::AllExamples;
using ::sinew::policy::testing::Example;
using ::sinew::policy::testing::PolicyExamples;
using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;

constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;

std::map<std::string, TensorLocation> LocationsOf(const Example& example) {
  return *LocateSafetensors(SerializeSafetensors(example.weights), "weights");
}

onnx::ModelProto WriteAndParse(const Example& example) {
  const auto bytes = WriteOnnx(example.graph, example.graph_name,
                               LocationsOf(example), "weights.safetensors");
  EXPECT_THAT(bytes, IsOk()) << example.name;
  onnx::ModelProto model;
  EXPECT_TRUE(model.ParseFromString(*bytes)) << example.name;
  return model;
}

TEST(OnnxWriter, KeepsTheNamesOfInputsAndTaps) {
  const onnx::GraphProto graph = WriteAndParse(PolicyExamples()[0]).graph();

  EXPECT_EQ(graph.name(), "policy");
  ASSERT_EQ(graph.input_size(), 2);
  EXPECT_EQ(graph.input(0).name(), "observation");
  EXPECT_EQ(graph.input(1).name(), "noise");
  ASSERT_EQ(graph.output_size(), 2);
  EXPECT_EQ(graph.output(0).name(), "action");
  EXPECT_EQ(graph.output(1).name(), "mean");
  const auto& shape = graph.input(0).type().tensor_type().shape();
  EXPECT_EQ(shape.dim(0).dim_param(), "batch");
  EXPECT_EQ(shape.dim(1).dim_value(), 224);
}

TEST(OnnxWriter, PointsIntoTheSafetensorsFile) {
  const Example policy = PolicyExamples()[0];
  const std::string file = SerializeSafetensors(policy.weights);

  const onnx::GraphProto graph = WriteAndParse(policy).graph();

  int external = 0;
  for (const onnx::TensorProto& tensor : graph.initializer()) {
    if (tensor.data_location() != onnx::TensorProto::EXTERNAL) continue;
    ++external;
    std::map<std::string, std::string> data;
    for (const auto& entry : tensor.external_data()) {
      data[entry.key()] = entry.value();
    }
    const std::string name = tensor.name().substr(sizeof("parameter:") - 1);
    EXPECT_EQ(data["location"], "weights.safetensors");
    EXPECT_EQ(
        file.substr(std::stoll(data["offset"]), std::stoll(data["length"])),
        policy.weights.at(name).data)
        << name;
  }
  // Normaliser 2, layers 3 x 2, standard deviation 1; no critic.
  EXPECT_EQ(external, 9);
}

TEST(OnnxWriter, GivesTheSameBytesEveryTime) {
  for (const Example& example : AllExamples()) {
    const auto locations = LocationsOf(example);
    EXPECT_EQ(*WriteOnnx(example.graph, example.graph_name, locations, "w"),
              *WriteOnnx(example.graph, example.graph_name, locations, "w"))
        << example.name;
  }
}

TEST(OnnxWriter, DefinesEveryNameOnceAndBeforeItsUse) {
  for (const Example& example : AllExamples()) {
    const onnx::GraphProto graph = WriteAndParse(example).graph();
    std::set<std::string> names;
    for (const auto& input : graph.input()) names.insert(input.name());
    for (const auto& tensor : graph.initializer()) {
      EXPECT_TRUE(names.insert(tensor.name()).second) << tensor.name();
    }
    for (const onnx::NodeProto& node : graph.node()) {
      for (const std::string& input : node.input()) {
        EXPECT_TRUE(names.contains(input)) << example.name << " " << input;
      }
      EXPECT_TRUE(names.insert(node.output(0)).second) << node.output(0);
    }
  }
}

TEST(OnnxWriter, SaysWhatIsMissingInTheWeightsFile) {
  const Example policy = PolicyExamples()[0];
  auto locations = LocationsOf(policy);
  locations["policy/std"].length = 8;
  EXPECT_THAT(WriteOnnx(policy.graph, "policy", locations, "w"),
              StatusIs(kInvalid,
                       "parameter policy/std: expected 112 bytes in "
                       "the weights file, found 8"));

  locations.erase("policy/std");
  EXPECT_THAT(
      WriteOnnx(policy.graph, "policy", locations, "w"),
      StatusIs(kInvalid, "parameter policy/std: missing in the weights file"));
}

TEST(OnnxWriter, RefusesAWeightsFileInAnotherFolder) {
  const Example policy = PolicyExamples()[0];

  EXPECT_THAT(WriteOnnx(policy.graph, "policy", LocationsOf(policy), "../w"),
              StatusIs(kInvalid,
                       "weights_file: expected a file name without folder, "
                       "found \"../w\""));
}

}  // namespace
}  // namespace sinew::policy
