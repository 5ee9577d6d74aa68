#include "common/policy/plan.h"

#include <algorithm>
#include <map>
#include <set>

#include "absl/strings/string_view.h"
#include "common/digest.h"
#include "common/policy/linear_kernel.h"
#include "common/policy/validate.h"
#include "common/status_macros.h"

namespace sinew::policy::internal {
namespace {

using Shapes = std::map<std::string, std::vector<int64_t>>;

// Where element c of the patch of output position t comes from, within its
// channel; -1 if from nowhere.
int64_t SourcePosition(const v1::Node& node, int64_t length, int64_t t,
                       int64_t k) {
  int64_t at = 0;
  if (node.op() == v1::OP_CONV1D) {
    at = t * node.stride() + k - node.padding();
  } else {
    const int64_t scaled = t + node.padding() - k;
    if (scaled % node.stride() != 0) return -1;
    at = scaled / node.stride();
  }
  return at >= 0 && at < length ? at : -1;
}

Convolution MakeConvolution(const v1::Node& node, int64_t in_width,
                            int64_t out_width,
                            const std::vector<int64_t>& weight) {
  const int64_t channels = node.channels();
  const int64_t kernel = weight[2];
  const int64_t length = in_width / channels;
  Convolution convolution;
  convolution.out_channels = node.op() == v1::OP_CONV1D ? weight[0] : weight[1];
  convolution.out_length = out_width / convolution.out_channels;
  convolution.patch_width = channels * kernel;
  convolution.source.reserve(convolution.out_length * channels * kernel);
  for (int64_t t = 0; t < convolution.out_length; ++t) {
    for (int64_t c = 0; c < channels; ++c) {
      for (int64_t k = 0; k < kernel; ++k) {
        const int64_t at = SourcePosition(node, length, t, k);
        convolution.source.push_back(
            static_cast<int32_t>(at < 0 ? -1 : c * length + at));
      }
    }
  }
  return convolution;
}

// Builds a plan node by node.
class Planner {
 public:
  Planner(const v1::Graph& graph, const Shapes& shapes,
          const std::map<std::string, int64_t>& widths)
      : shapes_(shapes), widths_(widths) {
    for (const v1::GraphInput& input : graph.inputs()) AddValue(input.name());
    plan_.num_inputs = graph.inputs_size();
    for (const v1::Node& node : graph.nodes()) AddStep(node);
    for (const v1::Tap& tap : graph.taps()) {
      plan_.taps.push_back({.name = tap.name(), .value = index_[tap.value()]});
    }
  }

  Plan& plan() { return plan_; }

 private:
  int AddValue(const std::string& name) {
    const int64_t width = widths_.at(name);
    const int index = static_cast<int>(plan_.values.size());
    plan_.values.push_back(
        {.name = name, .width = width, .stride = RoundUp(width, kPanel)});
    index_[name] = index;
    return index;
  }

  void AddStep(const v1::Node& node) {
    Step step;
    step.op = node.op();
    for (const std::string& input : node.inputs()) {
      step.inputs.push_back(index_[input]);
    }
    step.output = AddValue(node.name());
    step.parameters.assign(node.parameters().begin(), node.parameters().end());
    step.first_parameter = num_parameters_;
    num_parameters_ += node.parameters_size();
    step.low = static_cast<float>(node.low());
    step.high = static_cast<float>(node.high());
    step.epsilon = static_cast<float>(node.epsilon());
    step.begin = node.begin();
    if (node.op() == v1::OP_ARGMIN || node.op() == v1::OP_GATHER) {
      step.codes = shapes_.at(node.parameters(0))[0];
    }
    if (node.op() == v1::OP_CONV1D || node.op() == v1::OP_CONV1D_TRANSPOSE) {
      AddConvolution(node, step);
    }
    plan_.steps.push_back(std::move(step));
  }

  void AddConvolution(const v1::Node& node, Step& step) {
    step.convolution = MakeConvolution(node, widths_.at(node.inputs(0)),
                                       widths_.at(node.name()),
                                       shapes_.at(node.parameters(0)));
    const Convolution& convolution = step.convolution;
    const int64_t rows = RoundUp(convolution.out_length, kRowBlock);
    plan_.patch_elements =
        std::max(plan_.patch_elements, rows * convolution.patch_width);
    plan_.result_elements =
        std::max(plan_.result_elements,
                 rows * RoundUp(convolution.out_channels, kPanel));
  }

  const Shapes& shapes_;
  const std::map<std::string, int64_t>& widths_;
  std::map<std::string, int> index_;
  int num_parameters_ = 0;
  Plan plan_;
};

// The graph alone with the parameters that it names, in a fixed order.
std::string Identity(const v1::Graph& graph, const Shapes& shapes) {
  v1::PolicyGraph identity;
  *identity.add_graphs() = graph;
  std::set<std::string> names;
  for (const v1::Node& node : graph.nodes()) {
    names.insert(node.parameters().begin(), node.parameters().end());
  }
  for (const std::string& name : names) {
    v1::Parameter* parameter = identity.add_parameters();
    parameter->set_name(name);
    const std::vector<int64_t>& shape = shapes.at(name);
    parameter->mutable_shape()->Add(shape.begin(), shape.end());
  }
  return SerializeDeterministically(identity);
}

}  // namespace

absl::StatusOr<Plan> MakePlan(const v1::PolicyGraph& graph,
                              absl::string_view graph_name) {
  SINEW_ASSIGN_OR_RETURN(const v1::Graph* one, FindGraph(graph, graph_name));
  SINEW_ASSIGN_OR_RETURN((const std::map<std::string, int64_t> widths),
                         InferWidths(graph, graph_name));
  Shapes shapes;
  for (const v1::Parameter& parameter : graph.parameters()) {
    shapes[parameter.name()].assign(parameter.shape().begin(),
                                    parameter.shape().end());
  }
  Planner planner(*one, shapes, widths);
  planner.plan().identity = Identity(*one, shapes);
  return std::move(planner.plan());
}

}  // namespace sinew::policy::internal
