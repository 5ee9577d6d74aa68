#ifndef SINEW_COMMON_POLICY_TESTING_REFERENCE_H_
#define SINEW_COMMON_POLICY_TESTING_REFERENCE_H_

#include <map>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "common/policy/safetensors.h"
#include "proto/sinew/v1/graph.pb.h"

namespace sinew::policy::testing {

// Values by name, [batch, width] row-major.
using ReferenceValues = std::map<std::string, std::vector<double>>;

// The second way to evaluate a graph: straight from the formulas of graph.proto
// and ops.h, one row and one element at a time, in double, sharing no code with
// the executors. Returns every tap. The graph must be valid and `inputs`
// complete.
//
// Thread-safety: pure function. Slow.
ReferenceValues RunReference(const v1::PolicyGraph& graph,
                             absl::string_view graph_name,
                             const TensorMap& weights,
                             const ReferenceValues& inputs, int batch);

// max |actual - expected| / max |expected|: how back ends are compared. At most
// 1e-5 in float32 is asked of each tap. Infinity if sizes differ or one is not
// finite where the other is.
double RelativeDifference(absl::Span<const float> actual,
                          absl::Span<const double> expected);
double RelativeDifference(absl::Span<const float> actual,
                          absl::Span<const float> expected);

}  // namespace sinew::policy::testing

#endif  // SINEW_COMMON_POLICY_TESTING_REFERENCE_H_
