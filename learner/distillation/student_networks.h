#ifndef SINEW_LEARNER_DISTILLATION_STUDENT_NETWORKS_H_
#define SINEW_LEARNER_DISTILLATION_STUDENT_NETWORKS_H_

#include <cstdint>

#include "absl/status/statusor.h"
#include "common/policy/safetensors.h"
#include "learner/update/normaliser.h"
#include "proto/sinew/v1/graph.pb.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew::learner {

// The networks that a distillation begins with, and where their normalisers
// are: one, or of own state and goal apart (common/policy/latent_builder.h).
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

// Writes the statistics of all observation columns into the normalisers of
// `weights`, the student's.
void WriteNormalisers(const Moments& moments, TensorMap& weights);
// The inverse: moments of `count` rows.
void InheritNormalisers(const TensorMap& weights, double count,
                        Moments& moments);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_DISTILLATION_STUDENT_NETWORKS_H_
