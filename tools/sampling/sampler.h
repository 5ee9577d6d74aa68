#ifndef SINEW_TOOLS_SAMPLING_SAMPLER_H_
#define SINEW_TOOLS_SAMPLING_SAMPLER_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "common/policy/executor.h"
#include "common/policy/ports.h"
#include "common/stop.h"
#include "deploy/bundle/bundle.h"
#include "sim/metrics/diversity.h"
#include "sim/metrics/foot_skate.h"
#include "sim/metrics/motion_energy.h"
#include "sim/world/body_state.h"
#include "sim/world/observation.h"
#include "tools/sampling/free_body.h"
#include "tools/sampling/sample_starts.h"

namespace sinew::sampling {

// One sample: what a body did from a start on. Frame 0 is the start.
struct SampleMotion {
  int start = 0;          // index into the starts
  int64_t sample = 0;     // the random stream of its noise
  bool diverged = false;  // then it ends with the last state that was sound
  // [frames, F] transition features (sim/metrics/transitions.h): the block
  // SELF_JOINT_SPACE of sim/world/observation.h.
  std::vector<float> states;
  metrics::PosePath path;  // the tracked bodies but the root
  // [frames - 1, Z] of each step: what was decoded, and its mean, that is the
  // prior's. Empty for the zero action.
  std::vector<float> latent, latent_mean;
  std::vector<double> upright_height;  // [frames] m; BodyLaw::upright_body
  metrics::FootSkate skate;
  metrics::MotionEnergy energy;
  // [frames, nq], where it was asked for.
  std::vector<double> qpos;

  int frames() const { return static_cast<int>(upright_height.size()); }
};

struct SampleOrder {
  absl::Span<const SampleStart> starts;
  int per_start = 1;  // samples of each, one after another
  int steps = 0;      // control steps, >= 1
  // Standard deviations of the prior by which the latent is off its mean: the
  // graph's noise is this times N(0, 1). Unset: no network, the zero action.
  std::optional<double> noise = std::nullopt;
  uint64_t seed = 0;
  int threads = 1;        // >= 1; never changes results
  int64_t keep_qpos = 0;  // of so many samples, the first ones
};

// Lets the prior of a bundle move bodies, by its graph "sample" alone: no
// reference, no goal, no end but that of the time. Sample n draws its noise
// from Philox by (seed, n, step), so one seed gives the same draws at every
// scale of the noise.
//
// Thread-safety: immutable; Run from any thread. Ownership: shares the bundle's
// character. Blocking: Run computes, seconds to minutes, or for one control
// step of all threads after a request to stop. Errors: Create is
// INVALID_ARGUMENT naming bundle, graph, expected and found for a bundle
// without such a graph, without tap "latent", or of other widths, and those of
// BodyLaw; Run is CANCELLED.
class Sampler {
 public:
  static absl::StatusOr<std::unique_ptr<const Sampler>> Create(
      const bundle::Bundle& bundle);

  // starts.size() * per_start samples, start by start; the same bits for any
  // number of threads.
  absl::StatusOr<std::vector<SampleMotion>> Run(const SampleOrder& order,
                                                const StopToken& stop) const;

  const BodyLaw& law() const { return *law_; }
  std::shared_ptr<const BodyLaw> shared_law() const { return law_; }
  int latent_width() const { return latent_width_; }
  int num_features() const { return features_.width(); }  // F
  // Appends the F features of a state.
  void AppendFeatures(const world::BodyState& state,
                      std::vector<float>& rows) const;

 private:
  class Group;
  Sampler(std::shared_ptr<const BodyLaw> law, policy::Ports ports,
          std::shared_ptr<const policy::WeightsPack> pack, int latent_width,
          world::ObservationBuilder features);

  const std::shared_ptr<const BodyLaw> law_;
  const policy::Ports ports_;
  const std::shared_ptr<const policy::WeightsPack> pack_;
  const int latent_width_;
  const world::ObservationBuilder features_;
};

}  // namespace sinew::sampling

#endif  // SINEW_TOOLS_SAMPLING_SAMPLER_H_
