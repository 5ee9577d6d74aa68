#ifndef SINEW_LEARNER_TRAINER_POLICY_SNAPSHOT_H_
#define SINEW_LEARNER_TRAINER_POLICY_SNAPSHOT_H_

#include <cstdint>

#include "common/policy/safetensors.h"
#include "learner/trainer/experience.h"
#include "proto/sinew/v1/graph.pb.h"
#include "proto/sinew/v1/snapshot.pb.h"

namespace sinew::learner {

// What actors of `version` act with: the learner's graphs but "critic", their
// weights, the start table; serialised and digested. Actors run "policy" (and
// "teacher", where there is one); the others are there for whoever makes a
// bundle of the snapshot.
PublishedSnapshot MakePolicySnapshot(int64_t version,
                                     const v1::PolicyGraph& graph,
                                     const TensorMap& weights,
                                     const v1::CurriculumTable& curriculum);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_TRAINER_POLICY_SNAPSHOT_H_
