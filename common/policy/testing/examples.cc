#include "common/policy/testing/examples.h"

#include <utility>

#include "common/policy/validate.h"
#include "common/random/philox.h"

namespace sinew::policy::testing {

std::ostream& operator<<(std::ostream& out, const Example& example) {
  return out << example.name;
}

std::vector<Example> AllExamples() {
  std::vector<Example> examples = OpExamples();
  for (Example& example : PolicyExamples()) {
    examples.push_back(std::move(example));
  }
  return examples;
}

std::map<std::string, std::vector<float>> ExampleInputs(const Example& example,
                                                        int batch,
                                                        uint64_t seed) {
  const v1::Graph& graph = **FindGraph(example.graph, example.graph_name);
  std::map<std::string, std::vector<float>> inputs;
  uint64_t index = 0;
  for (const v1::GraphInput& input : graph.inputs()) {
    std::vector<float>& values = inputs[input.name()];
    values.resize(batch * input.width());
    const RandomKey key = {.seed = seed, .environment = index++};
    if (input.kind() == v1::GraphInput::KIND_UNIFORM) {
      FillUniform(key, absl::MakeSpan(values));
      continue;
    }
    FillNormal(key, absl::MakeSpan(values));
    if (input.kind() == v1::GraphInput::KIND_NORMAL) continue;
    for (float& value : values) value *= 2.0f;
  }
  return inputs;
}

}  // namespace sinew::policy::testing
