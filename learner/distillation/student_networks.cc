#include "learner/distillation/student_networks.h"

#include "common/policy/builder.h"
#include "common/policy/latent_builder.h"
#include "common/policy/select_graphs.h"
#include "common/status_macros.h"
#include "learner/update/training_graph.h"

namespace sinew::learner {
namespace {

absl::StatusOr<Student> MakeLatentStudent(const v1::Recipe& recipe,
                                          int64_t observation_width,
                                          int64_t self_observation_width,
                                          int64_t action_width) {
  const policy::LatentPolicyOptions options = {
      .self_observation_width = self_observation_width,
      .observation_width = observation_width,
      .action_width = action_width,
      .network = recipe.network()};
  Student student;
  SINEW_ASSIGN_OR_RETURN(student.graph, policy::BuildLatentPolicy(options));
  SINEW_ASSIGN_OR_RETURN(student.weights,
                         policy::InitialLatentWeights(options, recipe.seed()));
  return student;
}

}  // namespace

absl::StatusOr<Student> MakeStudent(const v1::Recipe& recipe,
                                    int64_t observation_width,
                                    int64_t self_observation_width,
                                    int64_t action_width) {
  if (recipe.network().has_latent()) {
    return MakeLatentStudent(recipe, observation_width, self_observation_width,
                             action_width);
  }
  const policy::TrackingPolicyOptions options = {
      .observation_width = observation_width,
      .action_width = action_width,
      .network = recipe.network()};
  SINEW_ASSIGN_OR_RETURN(const v1::PolicyGraph explores,
                         policy::BuildTrackingPolicy(options));
  SINEW_ASSIGN_OR_RETURN(const TensorMap all,
                         policy::InitialWeights(options, recipe.seed()));
  Student student;
  SINEW_ASSIGN_OR_RETURN(student.graph, WithoutExploration(explores));
  student.weights = policy::WeightsOf(student.graph, all);
  return student;
}

}  // namespace sinew::learner
