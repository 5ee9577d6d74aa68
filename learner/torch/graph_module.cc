#include "learner/torch/graph_module.h"

#include <algorithm>
#include <map>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/check.h"
#include "common/policy/validate.h"
#include "common/status_macros.h"
#include "learner/torch/graph_ops.h"

namespace sinew::learner {
namespace {

// Multiply-adds per row of a node's products.
int64_t MultiplyAdds(const v1::Node& node, int64_t input_width, int64_t width,
                     absl::Span<const v1::Parameter* const> parameters) {
  switch (node.op()) {
    case v1::OP_LINEAR:
      return input_width * width;
    case v1::OP_CONV1D:  // every output: channels x kernel
      return width * parameters[0]->shape(1) * parameters[0]->shape(2);
    case v1::OP_CONV1D_TRANSPOSE:  // every input: out channels x kernel
      return input_width * parameters[0]->shape(1) * parameters[0]->shape(2);
    default:
      return 0;
  }
}

}  // namespace

GraphModule::GraphModule(v1::Graph graph, Precision precision)
    : graph_(std::move(graph)), precision_(precision) {}

absl::StatusOr<std::unique_ptr<const GraphModule>> GraphModule::Create(
    const v1::PolicyGraph& graph, absl::string_view graph_name,
    Precision precision) {
  SINEW_RETURN_IF_ERROR(policy::ValidateGraph(graph));
  SINEW_ASSIGN_OR_RETURN(const v1::Graph* one,
                         policy::FindGraph(graph, graph_name));
  std::unique_ptr<GraphModule> module(new GraphModule(*one, precision));
  SINEW_RETURN_IF_ERROR(module->Resolve(graph));
  return module;
}

absl::Status GraphModule::Resolve(const v1::PolicyGraph& all) {
  using Widths = std::map<std::string, int64_t>;
  SINEW_ASSIGN_OR_RETURN(const Widths widths,
                         policy::InferWidths(all, graph_.name()));
  std::map<std::string, int> parameter_index;
  for (const v1::Parameter& parameter : all.parameters()) {
    parameter_index.emplace(parameter.name(), parameter_index.size());
    frozen_.push_back(parameter.frozen());
  }
  for (const v1::Node& node : graph_.nodes()) {
    NodeInfo info;
    for (const std::string& input : node.inputs()) {
      info.inputs.push_back(ValueIndex(input));
      info.trained |= Trained(info.inputs.back());
    }
    info.input_trained = Trained(info.inputs[0]);
    std::vector<const v1::Parameter*> parameters;
    for (const std::string& name : node.parameters()) {
      info.parameters.push_back(parameter_index.at(name));
      parameters.push_back(&all.parameters(info.parameters.back()));
      info.parameter_trained |= !parameters.back()->frozen();
    }
    info.trained |= info.parameter_trained;
    info.multiply_adds = MultiplyAdds(node, widths.at(node.inputs(0)),
                                      widths.at(node.name()), parameters);
    nodes_.push_back(std::move(info));
  }
  return absl::OkStatus();
}

int GraphModule::ValueIndex(absl::string_view name) const {
  for (int i = 0; i < graph_.inputs_size(); ++i) {
    if (graph_.inputs(i).name() == name) return i;
  }
  for (int i = 0; i < graph_.nodes_size(); ++i) {
    if (graph_.nodes(i).name() == name) return graph_.inputs_size() + i;
  }
  return -1;
}

const std::string& GraphModule::ValueName(int value) const {
  return value < graph_.inputs_size()
             ? graph_.inputs(value).name()
             : graph_.nodes(value - graph_.inputs_size()).name();
}

const GraphModule::NodeInfo* GraphModule::NodeOf(int value) const {
  const int node = value - graph_.inputs_size();
  return node < 0 ? nullptr : &nodes_[node];
}

bool GraphModule::Trained(int value) const {
  const NodeInfo* node = NodeOf(value);
  return node != nullptr && node->trained;
}

absl::StatusOr<GraphPlan> GraphModule::MakePlan(
    absl::Span<const std::string> given,
    absl::Span<const std::string> wanted) const {
  GraphPlan plan;
  for (auto [names, values] :
       {std::pair{given, &plan.given}, std::pair{wanted, &plan.wanted}}) {
    for (const std::string& name : names) {
      values->push_back(ValueIndex(name));
      if (values->back() >= 0) continue;
      return absl::NotFoundError(absl::StrCat(
          "graph ", graph_.name(), ": no input or node \"", name, "\""));
    }
  }
  const int inputs = graph_.inputs_size();
  std::vector<bool> is_given(inputs + nodes_.size());
  std::vector<bool> needed(inputs + nodes_.size());
  for (const int value : plan.given) is_given[value] = true;
  for (const int value : plan.wanted) needed[value] = true;
  for (int value = inputs + graph_.nodes_size() - 1; value >= 0; --value) {
    if (!needed[value] || is_given[value]) continue;
    if (value < inputs) {
      return absl::InvalidArgumentError(
          absl::StrCat("graph ", graph_.name(), ": input \"", ValueName(value),
                       "\" is needed and not given"));
    }
    const NodeInfo& node = *NodeOf(value);
    for (const int input : node.inputs) needed[input] = true;
    plan.nodes.push_back(value - inputs);
    plan.forward_flops += 2.0 * node.multiply_adds;
    plan.backward_flops += 2.0 * node.multiply_adds *
                           (node.parameter_trained + node.input_trained);
  }
  std::reverse(plan.nodes.begin(), plan.nodes.end());
  return plan;
}

std::vector<std::string> GraphModule::FrozenFrontier(
    absl::Span<const std::string> wanted) const {
  const int inputs = graph_.inputs_size();
  std::vector<bool> needed(inputs + nodes_.size());
  for (const std::string& name : wanted) {
    const int value = ValueIndex(name);
    if (value >= 0) needed[value] = true;
  }
  std::vector<std::string> frontier;
  for (int value = inputs + graph_.nodes_size() - 1; value >= 0; --value) {
    if (!needed[value]) continue;
    if (!Trained(value)) {
      frontier.push_back(ValueName(value));
      continue;
    }
    for (const int input : NodeOf(value)->inputs) needed[input] = true;
  }
  std::reverse(frontier.begin(), frontier.end());
  return frontier;
}

std::vector<int> GraphModule::TrainedParameters(const GraphPlan& plan) const {
  std::vector<bool> read(frozen_.size());
  for (const int node : plan.nodes) {
    for (const int parameter : nodes_[node].parameters) read[parameter] = true;
  }
  std::vector<int> trained;
  for (size_t i = 0; i < read.size(); ++i) {
    if (read[i] && !frozen_[i]) trained.push_back(static_cast<int>(i));
  }
  return trained;
}

at::Tensor GraphModule::Evaluate(
    int node, absl::Span<const at::Tensor> values,
    absl::Span<const at::Tensor> parameters) const {
  std::vector<at::Tensor> inputs;
  for (const int input : nodes_[node].inputs) inputs.push_back(values[input]);
  std::vector<at::Tensor> own;
  for (const int parameter : nodes_[node].parameters) {
    own.push_back(parameters[parameter]);
  }
  return EvaluateOp(graph_.nodes(node), precision_, inputs, own);
}

std::vector<at::Tensor> GraphModule::Run(
    const GraphPlan& plan, absl::Span<const at::Tensor> given,
    absl::Span<const at::Tensor> parameters) const {
  SINEW_CHECK(given.size() == plan.given.size() &&
              parameters.size() == frozen_.size())
      << given.size() << " values, " << parameters.size() << " parameters";
  std::vector<at::Tensor> values(graph_.inputs_size() + nodes_.size());
  for (size_t i = 0; i < given.size(); ++i) values[plan.given[i]] = given[i];
  for (const int node : plan.nodes) {
    values[graph_.inputs_size() + node] = Evaluate(node, values, parameters);
  }
  std::vector<at::Tensor> wanted;
  for (const int value : plan.wanted) {
    wanted.push_back(values[value].to(at::kFloat));
  }
  return wanted;
}

}  // namespace sinew::learner
