#ifndef SINEW_COMMON_POLICY_PORTS_H_
#define SINEW_COMMON_POLICY_PORTS_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "proto/sinew/v1/graph.pb.h"

namespace sinew::policy {

// How a caller that gives observations and executes actions talks to a graph:
// one data input, noise inputs that may stay zero, one executed tap.
struct Ports {
  std::string observation;
  int64_t observation_width = 0;
  std::vector<std::string> noise;
  std::string action;
  int64_t action_width = 0;
};

// The ports of a valid graph. INVALID_ARGUMENT names the graph, what was
// expected and found: not exactly one data input or executed tap, or an input
// of another kind. NOT_FOUND: no graph of that name. Pure.
absl::StatusOr<Ports> FindPorts(const v1::PolicyGraph& graph,
                                absl::string_view graph_name);

}  // namespace sinew::policy

#endif  // SINEW_COMMON_POLICY_PORTS_H_
