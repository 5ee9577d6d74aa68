#ifndef SINEW_COMMON_POLICY_TESTING_EXAMPLES_H_
#define SINEW_COMMON_POLICY_TESTING_EXAMPLES_H_

#include <map>
#include <ostream>
#include <string>
#include <vector>

#include "common/policy/safetensors.h"
#include "proto/sinew/v1/graph.pb.h"

namespace sinew::policy::testing {

// A graph with weights that every back end must evaluate alike.
struct Example {
  std::string name;  // [a-z0-9_]+
  v1::PolicyGraph graph;
  std::string graph_name;  // the one to run
  TensorMap weights;
};

// For gtest's parameterised tests.
std::ostream& operator<<(std::ostream& out, const Example& example);

// One small graph for each operation (some operations in several settings),
// with widths that fill no vector register evenly.
std::vector<Example> OpExamples();

// Whole policies: the tracking policy and critic with each activation and in
// several sizes, composers over primitives, every graph of a policy with a
// latent, and an autoencoder with quantiser and experts that uses every
// remaining operation. The first is our humanoid's policy.
std::vector<Example> PolicyExamples();

// Both lists.
std::vector<Example> AllExamples();

// Inputs of the example's graph by name, [batch, width] float32: normal with
// standard deviation 2 (DATA), standard normal, or uniform; a function of
// example, batch row and seed.
std::map<std::string, std::vector<float>> ExampleInputs(const Example& example,
                                                        int batch,
                                                        uint64_t seed);

}  // namespace sinew::policy::testing

#endif  // SINEW_COMMON_POLICY_TESTING_EXAMPLES_H_
