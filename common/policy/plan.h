#ifndef SINEW_COMMON_POLICY_PLAN_H_
#define SINEW_COMMON_POLICY_PLAN_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "proto/sinew/v1/graph.pb.h"

namespace sinew::policy::internal {

// A graph with its names resolved: what an executor walks through.

// An input's or a node's result: [rows, stride] float32, stride rounded up to
// whole panels. Columns from width on hold finite numbers of no meaning, but
// for inputs and linear layers zeros.
struct Value {
  std::string name;
  int64_t width = 0;
  int64_t stride = 0;
};

// A convolution as a linear layer over patches: output position t sees
// patch[t, c * kernel + k] = x[source[t * patch_width + c * kernel + k]], or 0
// where the source is -1.
struct Convolution {
  int64_t out_channels = 0;
  int64_t out_length = 0;
  int64_t patch_width = 0;
  std::vector<int32_t> source;
};

// One node.
struct Step {
  v1::Op op = v1::OP_UNSPECIFIED;
  std::vector<int> inputs;  // indices of values, all smaller than output
  int output = 0;
  // Names and shapes of parameters; packed ones start at first_parameter in
  // WeightsPack::parameters.
  std::vector<std::string> parameters;
  int first_parameter = 0;
  // Attributes.
  float low = 0;
  float high = 0;
  float epsilon = 0;
  int64_t begin = 0;
  int64_t codes = 0;  // rows of a codebook
  Convolution convolution;
};

struct Plan {
  std::vector<Value> values;  // inputs first
  int num_inputs = 0;
  std::vector<Step> steps;
  struct Tap {
    std::string name;
    int value = 0;
  };
  std::vector<Tap> taps;
  // Elements of scratch that convolutions need for patches and results.
  int64_t patch_elements = 0;
  int64_t result_elements = 0;
  // Equal for plans that may exchange weights: the graph and its shapes.
  std::string identity;
};

// Resolves a graph that ValidateGraph accepts. NOT_FOUND: no such graph.
absl::StatusOr<Plan> MakePlan(const v1::PolicyGraph& graph,
                              absl::string_view graph_name);

}  // namespace sinew::policy::internal

#endif  // SINEW_COMMON_POLICY_PLAN_H_
