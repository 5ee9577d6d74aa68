#ifndef SINEW_DEPLOY_RUNTIME_LATENT_NETWORKS_H_
#define SINEW_DEPLOY_RUNTIME_LATENT_NETWORKS_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "common/policy/executor.h"
#include "deploy/bundle/bundle.h"

namespace sinew::runtime {

// The networks of a bundle with a latent (deploy/bundle/latent_graphs.h), one
// row at a time. O observation columns, S of them the body's own state, Z of
// the latent, A actions. Numbers are not checked: NaN in gives NaN out.
//
//   Gaussian z = networks.Encode(observation);   // or networks.Prior(own)
//   networks.Decode(own, z.mean)  ->  what "policy" does without noise
//
// Thread-safety: one caller. Ownership: owns its executors; results are views
// of them, each valid until the same method is called again. Blocking: nothing
// allocates or locks after Create. Errors: Create: those of PackWeights,
// FAILED_PRECONDITION for a bundle without a latent; widths are CHECKed.
class LatentNetworks {
 public:
  // N(mean, diag std^2), [Z] each.
  struct Gaussian {
    absl::Span<const float> mean;
    absl::Span<const float> std;
  };

  static absl::StatusOr<std::unique_ptr<LatentNetworks>> Create(
      const bundle::Bundle& bundle);

  int width() const { return width_; }

  // Of an observation [O]; of the body's own state [S].
  Gaussian Encode(absl::Span<const float> observation);
  Gaussian Prior(absl::Span<const float> own);
  // Actions [A] of the body's own state [S] and a latent, or N(0, 1) noise that
  // becomes one around the prior's mean, [Z].
  absl::Span<const float> Decode(absl::Span<const float> own,
                                 absl::Span<const float> latent);
  absl::Span<const float> Sample(absl::Span<const float> own,
                                 absl::Span<const float> noise);

 private:
  // An executor with its ports by number.
  struct Network {
    std::unique_ptr<policy::Executor> executor;
    std::vector<int> inputs, taps;

    void Run();
    void Set(size_t input, absl::Span<const float> values);
    absl::Span<const float> Tap(size_t tap) const;
  };

  LatentNetworks() = default;
  static absl::StatusOr<Network> MakeNetwork(
      const bundle::Bundle& bundle, const std::string& graph,
      const std::vector<std::string>& inputs,
      const std::vector<std::string>& taps);

  int width_ = 0;
  Network encoder_, prior_, decoder_, sample_;
};

}  // namespace sinew::runtime

#endif  // SINEW_DEPLOY_RUNTIME_LATENT_NETWORKS_H_
