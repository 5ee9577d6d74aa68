#ifndef SINEW_TOOLS_SAMPLING_SAMPLE_FIGURES_H_
#define SINEW_TOOLS_SAMPLING_SAMPLE_FIGURES_H_

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "common/stop.h"
#include "sim/metrics/diversity.h"
#include "sim/metrics/foot_skate.h"
#include "sim/metrics/latent_continuity.h"
#include "sim/metrics/motion_energy.h"
#include "sim/metrics/transitions.h"
#include "tools/sampling/library_transitions.h"
#include "tools/sampling/sampler.h"

namespace sinew::sampling {

// One sample's row.
struct SampleRow {
  std::string start;
  double seconds = 0;  // that it ran
  bool began_upright = false;
  bool upright = false;       // at the end; a diverged sample is not
  bool ever_upright = false;  // in some frame
  bool diverged = false;
  double end_height = 0;     // of the head, share of its standing height
  double root_distance = 0;  // m over the floor, from start to end
  // m/s; NaN: no foot touched the floor.
  double foot_skate = std::numeric_limits<double>::quiet_NaN();
};

// What is said of all samples of one way to act.
struct SampleFigures {
  std::string name;             // "noise 1", "zero action" ...
  std::optional<double> noise;  // unset: the zero action
  int samples = 0, starts = 0, diverged = 0;
  // Upright: kUprightShare. Of those that began upright, the share that is so
  // at the end; of those that did not, the shares that are so at the end and in
  // no frame at all. NaN where there are none.
  int began_upright = 0;
  double upright_share = std::numeric_limits<double>::quiet_NaN();
  double got_up_share = std::numeric_limits<double>::quiet_NaN();
  double stuck_share = std::numeric_limits<double>::quiet_NaN();
  metrics::DiversityFigures diversity;
  metrics::FootSkate skate;
  metrics::MotionEnergy energy;
  metrics::LatentContinuity latent;       // what was decoded
  metrics::LatentContinuity latent_mean;  // the prior's means along the motion
  // Where there is a library to compare with. Of a sample the states after each
  // step count, not the one that it begins in, which is mostly the library's
  // own: n steps are n - 1 transitions, as of the student (AddStudent).
  std::optional<metrics::TransitionFigures> transitions;
  int64_t all_transitions = 0;         // before thinning
  std::vector<double> coverage_curve;  // at kCoverageThresholds
  // Of what the student covers, the share that is covered; NaN where it was
  // not asked for.
  double student_coverage = std::numeric_limits<double>::quiet_NaN();
  std::vector<SampleRow> rows;
};

// Where a coverage depends on its threshold, a reader wants to see how.
inline constexpr double kCoverageThresholds[] = {0.25, 0.35, 0.5, 0.7, 1.0};

struct FigureOptions {
  double threshold = 0.5;            // > 0; sim/metrics/transitions.h
  int64_t most_transitions = 40000;  // >= 1; that are compared
  int threads = 1;
};

// `motions` are those of Sampler::Run for these starts. `library` may be null.
// Same inputs, same bits, however many threads. Blocking: computes; seconds for
// the nearest neighbours. Errors: those of MatchTransitions;
// CANCELLED.
absl::StatusOr<SampleFigures> MeasureSamples(
    const Sampler& sampler, absl::Span<const SampleStart> starts,
    absl::Span<const SampleMotion> motions, const LibraryTransitions* library,
    const FigureOptions& options, const StopToken& stop);

// Share of library transitions within each of kCoverageThresholds.
std::vector<double> CoverageCurve(const metrics::TransitionMatch& match);

}  // namespace sinew::sampling

#endif  // SINEW_TOOLS_SAMPLING_SAMPLE_FIGURES_H_
