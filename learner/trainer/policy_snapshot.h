#ifndef SINEW_LEARNER_TRAINER_POLICY_SNAPSHOT_H_
#define SINEW_LEARNER_TRAINER_POLICY_SNAPSHOT_H_

#include <cstdint>
#include <set>
#include <string>

#include "common/policy/safetensors.h"
#include "learner/trainer/experience.h"
#include "proto/sinew/v1/graph.pb.h"
#include "proto/sinew/v1/snapshot.pb.h"

namespace sinew::learner {

// The graphs named in `keep` with the parameters they use; others and theirs
// are left out. Pure.
v1::PolicyGraph SelectGraphs(const v1::PolicyGraph& graph,
                             const std::set<std::string>& keep);

// The tensors that a graph's parameters name. Pure; absent ones are left out.
TensorMap SelectWeights(const v1::PolicyGraph& graph, const TensorMap& weights);

// What actors of `version` act with: graph "policy" alone, its weights, the
// start table; serialised and digested.
PublishedSnapshot MakePolicySnapshot(int64_t version,
                                     const v1::PolicyGraph& graph,
                                     const TensorMap& weights,
                                     const v1::CurriculumTable& curriculum);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_TRAINER_POLICY_SNAPSHOT_H_
