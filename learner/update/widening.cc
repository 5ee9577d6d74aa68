#include "learner/update/widening.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <vector>

#include "absl/algorithm/container.h"
#include "absl/types/span.h"

namespace sinew::learner {
namespace {

bool IsActivation(v1::Op op) {
  return op == v1::OP_RELU || op == v1::OP_ELU || op == v1::OP_SILU ||
         op == v1::OP_TANH || op == v1::OP_SIGMOID;
}

// The values of one graph: who writes and who reads them.
class Flow {
 public:
  explicit Flow(const v1::Graph& graph) {
    for (const v1::Node& node : graph.nodes()) {
      writers_[node.name()] = &node;
      for (const std::string& input : node.inputs()) {
        readers_[input].push_back(&node);
      }
    }
    for (const v1::Tap& tap : graph.taps()) tapped_.insert(tap.value());
  }

  // Whether `layer`, a LINEAR, is a hidden one.
  bool IsHidden(const v1::Node& layer) const {
    return AreRead(layer, [this](const v1::Node& activation) {
      return IsActivation(activation.op()) &&
             AreRead(activation, [](const v1::Node& next) {
               return next.op() == v1::OP_LINEAR;
             });
    });
  }

  // Whether `layer`, a LINEAR, reads a hidden one.
  bool ReadsHidden(const v1::Node& layer) const {
    const v1::Node* activation = Writer(layer);
    if (activation == nullptr || !IsActivation(activation->op())) return false;
    const v1::Node* before = Writer(*activation);
    return before != nullptr && before->op() == v1::OP_LINEAR &&
           IsHidden(*before);
  }

 private:
  // Of the first input, if a node writes it.
  const v1::Node* Writer(const v1::Node& node) const {
    const auto found = writers_.find(node.inputs(0));
    return found == writers_.end() ? nullptr : found->second;
  }
  // Whether somebody reads it, and every reader is such a one.
  template <typename Predicate>
  bool AreRead(const v1::Node& node, Predicate is) const {
    const auto found = readers_.find(node.name());
    return found != readers_.end() && !tapped_.contains(node.name()) &&
           absl::c_all_of(found->second, [&is](const v1::Node* reader) {
             return is(*reader);
           });
  }

  std::map<std::string, const v1::Node*> writers_;
  std::map<std::string, std::vector<const v1::Node*>> readers_;
  std::set<std::string> tapped_;
};

}  // namespace

HiddenWidths::HiddenWidths(const v1::PolicyGraph& graph) {
  for (const v1::Graph& one : graph.graphs()) {
    const Flow flow(one);
    for (const v1::Node& node : one.nodes()) {
      const bool linear = node.op() == v1::OP_LINEAR;
      if (!linear || !flow.IsHidden(node)) {
        fixed_rows_.insert(node.parameters().begin(), node.parameters().end());
      }
      if (!linear || !flow.ReadsHidden(node)) {
        fixed_columns_.insert(node.parameters().begin(),
                              node.parameters().end());
      }
    }
  }
}

bool HiddenWidths::CanWiden(absl::string_view name, const HostTensor& narrow,
                            const HostTensor& wide) const {
  const size_t rank = wide.shape.size();
  if (narrow.dtype != wide.dtype || narrow.shape.size() != rank || rank < 1 ||
      rank > 2) {
    return false;
  }
  const auto fits = [&](size_t extent, bool fixed) {
    return fixed ? narrow.shape[extent] == wide.shape[extent]
                 : narrow.shape[extent] <= wide.shape[extent];
  };
  return fits(0, fixed_rows_.contains(name)) &&
         (rank == 1 || fits(1, fixed_columns_.contains(name)));
}

void Widen(const HostTensor& narrow, HostTensor& wide) {
  const bool matrix = wide.shape.size() == 2;
  const int64_t columns = matrix ? wide.shape[1] : 1;
  const int64_t known = matrix ? narrow.shape[1] : 1;
  const absl::Span<const float> from = narrow.float32();
  const absl::Span<float> into = wide.mutable_float32();
  for (int64_t row = 0; row < narrow.shape[0]; ++row) {
    const absl::Span<float> to = into.subspan(row * columns, columns);
    absl::c_copy(from.subspan(row * known, known), to.begin());
    std::fill(to.begin() + known, to.end(), 0.0f);
  }
}

}  // namespace sinew::learner
