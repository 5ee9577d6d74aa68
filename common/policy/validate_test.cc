#include "common/policy/validate.h"

#include <functional>
#include <string>
#include <vector>

#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "google/protobuf/text_format.h"
#include "gtest/gtest.h"

namespace sinew::policy {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::IsOkAndHolds;
using ::sinew::testing::StatusIs;
using ::testing::ElementsAre;
using ::testing::Pair;

constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;

// x [4] -> linear [3] -> clamp, with a Gaussian tap.
v1::PolicyGraph ValidGraph() {
  v1::PolicyGraph graph;
  const bool parsed = google::protobuf::TextFormat::ParseFromString(
      R"pb(
        format_version: 1
        graphs {
          name: "policy"
          inputs { name: "x" width: 4 kind: KIND_DATA }
          nodes {
            name: "layer"
            op: OP_LINEAR
            inputs: "x"
            parameters: "w"
            parameters: "b"
          }
          nodes { name: "limited" op: OP_CLAMP inputs: "layer" low: -1 high: 1 }
          taps {
            name: "action"
            value: "limited"
            executed: true
            gaussian { mean: "layer" std_parameter: "std" }
          }
        }
        parameters { name: "w" shape: 3 shape: 4 }
        parameters { name: "b" shape: 3 }
        parameters { name: "std" shape: 3 }
      )pb",
      &graph);
  EXPECT_TRUE(parsed);
  return graph;
}

TensorMap ValidWeights() {
  TensorMap weights;
  weights["w"] = HostTensor::Zeros({3, 4});
  weights["b"] = HostTensor::Zeros({3});
  weights["std"] = HostTensor::Float32({3}, {0.1f, 0.2f, 0.3f});
  return weights;
}

// One thing changed in the valid graph, and the complaint about it.
struct Fault {
  std::string name;
  std::function<void(v1::PolicyGraph&)> change;
  std::string message;
};

std::ostream& operator<<(std::ostream& out, const Fault& fault) {
  return out << fault.name;
}

v1::Graph& G(v1::PolicyGraph& graph) { return *graph.mutable_graphs(0); }
v1::Node& Layer(v1::PolicyGraph& graph) { return *G(graph).mutable_nodes(0); }
v1::Node& Limited(v1::PolicyGraph& graph) { return *G(graph).mutable_nodes(1); }
v1::Tap& Action(v1::PolicyGraph& graph) { return *G(graph).mutable_taps(0); }

// Makes node "limited" a convolution of the three columns of "layer".
void MakeConvolution(v1::PolicyGraph& graph, int64_t channels, int64_t stride) {
  v1::Node& node = Limited(graph);
  node.set_op(v1::OP_CONV1D);
  node.clear_low();
  node.clear_high();
  node.add_parameters("k");
  node.add_parameters("b");
  node.set_channels(channels);
  node.set_stride(stride);
  v1::Parameter* kernel = graph.add_parameters();
  kernel->set_name("k");
  for (const int64_t extent : {3, 1, 5}) kernel->add_shape(extent);
}

std::vector<Fault> GraphFaults() {
  return {
      {"Version", [](auto& g) { g.set_format_version(2); },
       "format_version: expected 1, found 2"},
      {"GraphTwice", [](auto& g) { *g.add_graphs() = g.graphs(0); },
       "graph policy: appears twice"},
      {"GraphName", [](auto& g) { G(g).set_name(""); },
       "graph: expected a name of letters, digits, \"_\", \".\", \"-\" and "
       "\"/\", found \"\""},
      {"ParameterTwice", [](auto& g) { *g.add_parameters() = g.parameters(0); },
       "parameter w: appears twice"},
      {"ParameterShape",
       [](auto& g) { g.mutable_parameters(0)->set_shape(0, 0); },
       "parameter w: expected extents >= 1 and at most 268435456 elements, "
       "found [0, 4]"},
      {"ParameterSize",
       [](auto& g) {
         g.mutable_parameters(0)->set_shape(0, int64_t{1} << 40);
         g.mutable_parameters(0)->set_shape(1, int64_t{1} << 40);
       },
       "parameter w: expected extents >= 1 and at most 268435456 elements, "
       "found [1099511627776, 1099511627776]"},
      {"InputKind",
       [](auto& g) {
         G(g).mutable_inputs(0)->set_kind(v1::GraphInput::KIND_UNSPECIFIED);
       },
       "graph policy: input x: expected kind DATA, NORMAL or UNIFORM, found "
       "0"},
      {"InputWidth", [](auto& g) { G(g).mutable_inputs(0)->set_width(0); },
       "graph policy: input x: expected a width in [1, 4194304], found 0"},
      {"InputTwice", [](auto& g) { *G(g).add_inputs() = G(g).inputs(0); },
       "graph policy: input x: appears twice"},
      {"NodeName", [](auto& g) { Layer(g).set_name("a b"); },
       "graph policy: node: expected a name of letters, digits, \"_\", \".\", "
       "\"-\" and \"/\", found \"a b\""},
      {"NodeTwice", [](auto& g) { Limited(g).set_name("layer"); },
       "graph policy: node layer (OP_CLAMP): appears twice"},
      {"NodeInput", [](auto& g) { Layer(g).set_inputs(0, "limited"); },
       "graph policy: node layer (OP_LINEAR): expected an input or an earlier "
       "node, found \"limited\""},
      {"NodeParameter", [](auto& g) { Layer(g).set_parameters(0, "v"); },
       "graph policy: node layer (OP_LINEAR): expected a declared parameter, "
       "found \"v\""},
      {"Op", [](auto& g) { Layer(g).set_op(v1::OP_UNSPECIFIED); },
       "graph policy: node layer (OP_UNSPECIFIED): expected an operation, "
       "found op 0"},
      {"Inputs", [](auto& g) { Layer(g).add_inputs("x"); },
       "graph policy: node layer (OP_LINEAR): expected 1 inputs, found 2"},
      {"NoInput", [](auto& g) { Layer(g).clear_inputs(); },
       "graph policy: node layer (OP_LINEAR): expected 1 inputs, found 0"},
      {"Parameters", [](auto& g) { Limited(g).add_parameters("b"); },
       "graph policy: node limited (OP_CLAMP): expected 0 parameters, found "
       "1"},
      {"Attribute", [](auto& g) { Layer(g).set_epsilon(0.5); },
       "graph policy: node layer (OP_LINEAR): attribute epsilon: expected "
       "unset, found 0.5"},
      {"Clamp", [](auto& g) { Limited(g).set_low(1); },
       "graph policy: node limited (OP_CLAMP): attributes low and high: "
       "expected low < high, found 1 and 1"},
      {"Weight", [](auto& g) { g.mutable_parameters(0)->set_shape(1, 5); },
       "graph policy: node layer (OP_LINEAR): weight: expected shape [3, 4], "
       "found [3, 5]"},
      {"WeightRank", [](auto& g) { g.mutable_parameters(0)->add_shape(1); },
       "graph policy: node layer (OP_LINEAR): weight: expected 2 extents, "
       "found [3, 4, 1]"},
      {"Bias", [](auto& g) { g.mutable_parameters(1)->set_shape(0, 2); },
       "graph policy: node layer (OP_LINEAR): bias: expected shape [3], found "
       "[2]"},
      {"Slice",
       [](auto& g) {
         Limited(g).set_op(v1::OP_SLICE);
         Limited(g).clear_low();
         Limited(g).clear_high();
         Limited(g).set_begin(2);
         Limited(g).set_end(4);
       },
       "graph policy: node limited (OP_SLICE): attributes begin and end: "
       "expected 0 <= begin < end <= 3, found 2 and 4"},
      {"Add",
       [](auto& g) {
         Limited(g).set_op(v1::OP_ADD);
         Limited(g).clear_low();
         Limited(g).clear_high();
         Limited(g).add_inputs("x");
       },
       "graph policy: node limited (OP_ADD): expected inputs of equal width, "
       "found 3 and 4"},
      {"WeightedSum",
       [](auto& g) {
         Limited(g).set_op(v1::OP_WEIGHTED_SUM);
         Limited(g).clear_low();
         Limited(g).clear_high();
         Limited(g).add_inputs("x");
       },
       "graph policy: node limited (OP_WEIGHTED_SUM): expected one weight for "
       "each of 1 inputs, found a first input of width 3"},
      {"ConvolutionLength", [](auto& g) { MakeConvolution(g, 1, 1); },
       "graph policy: node limited (OP_CONV1D): expected a result of length "
       ">= 1, found 0"},
      {"ConvolutionChannels", [](auto& g) { MakeConvolution(g, 2, 1); },
       "graph policy: node limited (OP_CONV1D): attribute channels: expected a "
       "divisor of the input's width 3, found 2"},
      {"ConvolutionStride", [](auto& g) { MakeConvolution(g, 1, 0); },
       "graph policy: node limited (OP_CONV1D): attributes stride and padding: "
       "expected >= 1 and >= 0, found 0 and 0"},
      {"TapTwice", [](auto& g) { *G(g).add_taps() = G(g).taps(0); },
       "graph policy: tap action: another tap or an input has this name"},
      {"TapLikeInput", [](auto& g) { Action(g).set_name("x"); },
       "graph policy: tap x: another tap or an input has this name"},
      {"TapValue", [](auto& g) { Action(g).set_value("y"); },
       "graph policy: tap action: value: expected an input or a node, found "
       "\"y\""},
      {"TwoExecuted",
       [](auto& g) {
         v1::Tap* tap = G(g).add_taps();
         tap->set_name("second");
         tap->set_value("layer");
         tap->set_executed(true);
       },
       "graph policy: tap second: expected at most one executed tap, found "
       "two"},
      {"Period", [](auto& g) { Action(g).set_decision_period(-1); },
       "graph policy: tap action: decision_period: expected >= 0, found -1"},
      {"GaussianMean",
       [](auto& g) { Action(g).mutable_gaussian()->set_mean("x"); },
       "graph policy: tap action: gaussian.mean: expected width 3, found 4"},
      {"GaussianStd",
       [](auto& g) { Action(g).mutable_gaussian()->set_std_parameter("w"); },
       "graph policy: tap action: gaussian.std_parameter: expected shape [3], "
       "found [3, 4]"},
      {"GaussianStdName",
       [](auto& g) { Action(g).mutable_gaussian()->set_std_parameter("s"); },
       "graph policy: tap action: gaussian.std_parameter: expected a declared "
       "parameter, found \"s\""},
      {"CategoricalClasses",
       [](auto& g) {
         Action(g).mutable_categorical()->set_logits("x");
         Action(g).mutable_categorical()->add_classes(1);
       },
       "graph policy: tap action: categorical.classes: expected >= 2, found "
       "1"},
      {"CategoricalSum",
       [](auto& g) {
         Action(g).mutable_categorical()->set_logits("x");
         Action(g).mutable_categorical()->add_classes(3);
       },
       "graph policy: tap action: categorical.classes: expected a sum of 4 "
       "(the width of the logits), found 3"},
      {"CategoricalValue",
       [](auto& g) {
         Action(g).mutable_categorical()->set_logits("x");
         Action(g).mutable_categorical()->add_classes(2);
         Action(g).mutable_categorical()->add_classes(2);
       },
       "graph policy: tap action: value: expected one index for each of 2 "
       "categoricals, found width 3"},
      {"TotalWidth",
       [](auto& g) {
         for (int i = 0; i < 5; ++i) {
           v1::GraphInput* input = G(g).add_inputs();
           input->set_name("wide" + std::to_string(i));
           input->set_width(1 << 22);
           input->set_kind(v1::GraphInput::KIND_DATA);
         }
       },
       "graph policy: expected widths that add up to at most 16777216, found "
       "20971530"},
  };
}

class ValidateGraphOn : public ::testing::TestWithParam<Fault> {};

INSTANTIATE_TEST_SUITE_P(Faults, ValidateGraphOn,
                         ::testing::ValuesIn(GraphFaults()),
                         [](const auto& info) { return info.param.name; });

TEST_P(ValidateGraphOn, NamesTheFault) {
  v1::PolicyGraph graph = ValidGraph();

  GetParam().change(graph);

  EXPECT_THAT(ValidateGraph(graph), StatusIs(kInvalid, GetParam().message));
}

TEST(ValidateGraph, AcceptsAValidGraphWithItsWeights) {
  TensorMap weights = ValidWeights();
  weights["adam/w"] = HostTensor::Zeros({7});

  EXPECT_THAT(ValidateGraph(ValidGraph(), weights), IsOk());
}

TEST(ValidateGraph, NamesTheWeightThatDoesNotFit) {
  TensorMap weights = ValidWeights();
  weights.erase("b");
  EXPECT_THAT(ValidateGraph(ValidGraph(), weights),
              StatusIs(kInvalid, "weights: parameter b: missing"));

  weights["b"] = HostTensor::Zeros({4});
  EXPECT_THAT(ValidateGraph(ValidGraph(), weights),
              StatusIs(kInvalid,
                       "weights: parameter b: expected shape [3], "
                       "found [4]"));

  weights["b"] = HostTensor::Float64({3}, {0, 0, 0});
  EXPECT_THAT(ValidateGraph(ValidGraph(), weights),
              StatusIs(kInvalid,
                       "weights: parameter b: expected FLOAT32, found "
                       "DATA_TYPE_FLOAT64"));
}

TEST(ValidateGraph, RefusesAStandardDeviationThatIsNotPositive) {
  TensorMap weights = ValidWeights();
  weights["std"].mutable_float32()[1] = 0;

  EXPECT_THAT(ValidateGraph(ValidGraph(), weights),
              StatusIs(kInvalid,
                       "graph policy: tap action: parameter std: expected "
                       "finite standard deviations > 0, found 0"));
}

TEST(InferWidths, GivesTheWidthOfEveryValue) {
  EXPECT_THAT(InferWidths(ValidGraph(), "policy"),
              IsOkAndHolds(ElementsAre(Pair("layer", 3), Pair("limited", 3),
                                       Pair("x", 4))));
}

TEST(InferWidths, SaysWhichGraphsThereAre) {
  EXPECT_THAT(InferWidths(ValidGraph(), "critic"),
              StatusIs(absl::StatusCode::kNotFound,
                       "expected a graph named \"critic\", found [policy]"));
}

}  // namespace
}  // namespace sinew::policy
