#ifndef SINEW_COMMON_POLICY_SELECT_GRAPHS_H_
#define SINEW_COMMON_POLICY_SELECT_GRAPHS_H_

#include <set>
#include <string>

#include "common/policy/safetensors.h"
#include "proto/sinew/v1/graph.pb.h"

namespace sinew::policy {

// Parts of a policy for those who need no more: actors no critic, a robot no
// teacher.
//
// Thread-safety: pure functions. Blocking: never. Errors: none.

// The graphs but those named in `left_out`, in their order, with the parameters
// that they use.
v1::PolicyGraph GraphsWithout(const v1::PolicyGraph& graph,
                              const std::set<std::string>& left_out);

// The tensors that a graph's parameters name; absent ones are left out.
TensorMap WeightsOf(const v1::PolicyGraph& graph, const TensorMap& weights);

}  // namespace sinew::policy

#endif  // SINEW_COMMON_POLICY_SELECT_GRAPHS_H_
