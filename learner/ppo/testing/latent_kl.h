#ifndef SINEW_LEARNER_PPO_TESTING_LATENT_KL_H_
#define SINEW_LEARNER_PPO_TESTING_LATENT_KL_H_

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "absl/types/span.h"
#include "common/policy/executor.h"
#include "common/policy/safetensors.h"
#include "proto/sinew/v1/graph.pb.h"

namespace sinew::learner {

// KL(posterior || prior) of every row, a second time: by the graphs "encoder"
// and "prior" that bundles have, the Eigen executor, and deviations in place of
// variances. `observations`: [rows, width], of which the first `own` columns
// are the body's own state. Aborts if the graphs do not fit.
inline std::vector<double> LatentKl(const v1::PolicyGraph& graph,
                                    const TensorMap& weights,
                                    absl::Span<const float> observations,
                                    size_t width, size_t own) {
  struct Normal {
    absl::Span<const float> mean, std;
  };
  const auto executor_of = [&](const char* name) {
    return *policy::Executor::Create(*policy::PackWeights(graph, name, weights),
                                     /*max_batch=*/1);
  };
  const auto run = [](policy::Executor& executor, const char* input,
                      absl::Span<const float> row) -> Normal {
    std::copy(row.begin(), row.end(),
              executor.input(executor.input_index(input)).begin());
    executor.Run(1);
    return {executor.tap(executor.tap_index("mean")),
            executor.tap(executor.tap_index("std"))};
  };
  const auto encoder = executor_of("encoder");
  const auto prior = executor_of("prior");
  std::vector<double> kl;
  for (size_t first = 0; first < observations.size(); first += width) {
    const auto row = observations.subspan(first, width);
    const Normal posterior = run(*encoder, "observation", row);
    const Normal guess = run(*prior, "self_observation", row.first(own));
    double sum = 0;
    for (size_t z = 0; z < guess.mean.size(); ++z) {
      const double s = posterior.std[z], r = guess.std[z];
      const double d = posterior.mean[z] - guess.mean[z];
      sum += std::log(r / s) + (s * s + d * d) / (2 * r * r) - 0.5;
    }
    kl.push_back(sum);
  }
  return kl;
}

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_PPO_TESTING_LATENT_KL_H_
