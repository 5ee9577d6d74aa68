#include "learner/distillation/student_networks.h"

#include <string>
#include <utility>
#include <vector>

#include "absl/types/span.h"
#include "common/policy/builder.h"
#include "common/policy/latent_builder.h"
#include "common/policy/select_graphs.h"
#include "common/status_macros.h"
#include "learner/distillation/training_graph.h"

namespace sinew::learner {
namespace {

// Prefixes of the normalisers, in the order of the columns that they see.
std::vector<std::string> Normalisers(const TensorMap& weights) {
  if (weights.contains("normaliser/own/mean")) {
    return {"normaliser/own", "normaliser/goal"};
  }
  return {"normaliser"};
}

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

void WriteNormalisers(const Moments& moments, TensorMap& weights) {
  size_t first = 0;
  for (const std::string& prefix : Normalisers(weights)) {
    HostTensor& mean = weights.at(prefix + "/mean");
    const size_t width = mean.num_elements();
    Moments part;
    part.count = moments.count;
    const auto columns = [&](const std::vector<double>& all) {
      const auto begin = all.begin() + static_cast<int64_t>(first);
      return std::vector<double>(begin, begin + static_cast<int64_t>(width));
    };
    part.mean = columns(moments.mean);
    part.squares = columns(moments.squares);
    WriteNormaliser(part, mean.mutable_float32(),
                    weights.at(prefix + "/inverse_std").mutable_float32());
    first += width;
  }
}

void InheritNormalisers(const TensorMap& weights, double count,
                        Moments& moments) {
  Moments all;
  all.count = count;
  for (const std::string& prefix : Normalisers(weights)) {
    const HostTensor& mean = weights.at(prefix + "/mean");
    Moments part(mean.num_elements());
    InheritMoments(mean.float32(),
                   weights.at(prefix + "/inverse_std").float32(), count, part);
    all.mean.insert(all.mean.end(), part.mean.begin(), part.mean.end());
    all.squares.insert(all.squares.end(), part.squares.begin(),
                       part.squares.end());
  }
  moments = std::move(all);
}

}  // namespace sinew::learner
