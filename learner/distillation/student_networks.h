#ifndef SINEW_LEARNER_DISTILLATION_STUDENT_NETWORKS_H_
#define SINEW_LEARNER_DISTILLATION_STUDENT_NETWORKS_H_

#include <cstdint>

#include "absl/status/statusor.h"
#include "common/policy/safetensors.h"
#include "proto/sinew/v1/graph.pb.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew::learner {

// The networks that a distillation begins with.
//
// Pure functions: thread-safe, never blocking for more than a fraction of a
// second.

struct Student {
  v1::PolicyGraph graph;
  TensorMap weights;
};

// As the recipe (defaults filled) says. INVALID_ARGUMENT names the option.
absl::StatusOr<Student> MakeStudent(const v1::Recipe& recipe,
                                    int64_t observation_width,
                                    int64_t self_observation_width,
                                    int64_t action_width);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_DISTILLATION_STUDENT_NETWORKS_H_
