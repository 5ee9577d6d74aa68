#ifndef SINEW_COMMON_POLICY_TEACHER_GRAPH_H_
#define SINEW_COMMON_POLICY_TEACHER_GRAPH_H_

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "common/policy/safetensors.h"
#include "proto/sinew/v1/graph.pb.h"

namespace sinew::policy {

// The graph by which a teacher acts in its share of a student's episodes
// (Distillation.teacher_share), and what names of its parameters begin with.
inline constexpr absl::string_view kTeacherGraph = "teacher";
inline constexpr absl::string_view kTeacherPrefix = "teacher/";

// Puts a teacher beside a student's graphs: graph "policy" of `teacher`, with
// nodes, inputs and taps as they are, becomes graph "teacher" of `graph`; its
// parameters are frozen, and they and their weights get the prefix. Learners
// whose recipe has a teacher_share give snapshots made like this; bundles do
// not need the graph.
//
//   AddTeacherGraph(bundle.graph, bundle.weights, graph, weights);
//
// Pure; does not block. INVALID_ARGUMENT: `teacher` and its weights are not
// valid or have no graph "policy", or `graph` has a graph "teacher" already;
// graph and weights are as they were then.
absl::Status AddTeacherGraph(const v1::PolicyGraph& teacher,
                             const TensorMap& teacher_weights,
                             v1::PolicyGraph& graph, TensorMap& weights);

}  // namespace sinew::policy

#endif  // SINEW_COMMON_POLICY_TEACHER_GRAPH_H_
