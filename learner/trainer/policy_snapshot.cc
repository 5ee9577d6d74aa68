#include "learner/trainer/policy_snapshot.h"

#include "common/digest.h"
#include "common/policy/select_graphs.h"

namespace sinew::learner {

PublishedSnapshot MakePolicySnapshot(int64_t version,
                                     const v1::PolicyGraph& graph,
                                     const TensorMap& weights,
                                     const v1::CurriculumTable& curriculum) {
  PublishedSnapshot result;
  result.snapshot.set_version(version);
  *result.snapshot.mutable_graph() = policy::GraphsWithout(graph, {"critic"});
  result.snapshot.set_weights(SerializeSafetensors(
      policy::WeightsOf(result.snapshot.graph(), weights)));
  *result.snapshot.mutable_curriculum() = curriculum;
  result.bytes = SerializeDeterministically(result.snapshot);
  result.sha256 = Sha256Hex(result.bytes);
  return result;
}

}  // namespace sinew::learner
