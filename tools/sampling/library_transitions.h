#ifndef SINEW_TOOLS_SAMPLING_LIBRARY_TRANSITIONS_H_
#define SINEW_TOOLS_SAMPLING_LIBRARY_TRANSITIONS_H_

#include <cstdint>
#include <optional>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/stop.h"
#include "sim/metrics/foot_skate.h"
#include "sim/metrics/latent_continuity.h"
#include "sim/metrics/motion_energy.h"
#include "sim/metrics/transitions.h"
#include "sim/motion/library.h"
#include "tools/evaluation/subject.h"
#include "tools/sampling/sampler.h"

namespace sinew::sampling {

// What generated transitions are compared with.
struct LibraryTransitions {
  metrics::Standardisation standardisation;
  metrics::FeatureRows rows;  // standardised, [L, 2 F]
  int64_t all = 0;            // of the library; L of them are compared with
  // Of the clips themselves: what samples can be measured by.
  metrics::FootSkate skate;
  metrics::MotionEnergy energy;
  // What the policy covers when it tracks the library, where that was asked
  // for, and how the latent moves meanwhile: its encoder's means, whose
  // consecutive ones a distillation holds together.
  std::optional<metrics::TransitionMatch> student = std::nullopt;
  int64_t student_all = 0;  // its transitions before thinning
  metrics::LatentContinuity student_latent = {};
};

// Frames t and t + 1 of every clip, left-out ones apart (a looping clip's last
// frame is followed by its first one, moved), thinned to `most`.
// INVALID_ARGUMENT: a library without two frames of one clip; CANCELLED.
absl::StatusOr<LibraryTransitions> MakeLibraryTransitions(
    const Sampler& sampler, const motion::Library& library, int64_t most,
    const StopToken& stop);

// Adds what is the student's: the graph "policy", mean action, tracks
// the clips piece by piece; a piece is at most `seconds` long and ends where
// the policy fails. Of a piece the states after each step count, not the one
// that it begins in, which is the library's own: n steps are n - 1 transitions.
// They are thinned to `most`. Blocking and errors: those of
// evaluation::RunStarts; FAILED_PRECONDITION: it survives no two steps
// anywhere.
absl::Status AddStudent(const Sampler& sampler,
                        const evaluation::Subject& subject, double seconds,
                        int64_t most, int threads, const StopToken& stop,
                        LibraryTransitions* transitions);

}  // namespace sinew::sampling

#endif  // SINEW_TOOLS_SAMPLING_LIBRARY_TRANSITIONS_H_
