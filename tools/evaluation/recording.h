#ifndef SINEW_TOOLS_EVALUATION_RECORDING_H_
#define SINEW_TOOLS_EVALUATION_RECORDING_H_

#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "common/stop.h"
#include "sim/character/character.h"
#include "sim/motion/library.h"
#include "tools/evaluation/subject.h"

namespace sinew::evaluation {

// A clip and what the policy made of it, pose by pose. Frame 0 is where both
// begin.
struct Recording {
  int nq = 0;
  double frames_per_second = 0;
  std::vector<double> reference;  // [frames, nq] qpos
  std::vector<double> simulated;  // [frames, nq] qpos
  // False: it ends with the frame that failed; from the floor: the body did
  // not stand and track at the end.
  bool survived = false;

  int frames() const {
    return nq == 0 ? 0 : static_cast<int>(simulated.size()) / nq;
  }
};

// The reference's poses from frame `first` on, [frames, nq]. Pure.
std::vector<double> ReferencePoses(const character::Character& character,
                                   const motion::Library& library, int clip,
                                   int first, int frames);

// Frames of a clip to show: those of `seconds` of a looping one (rounded, at
// least 2), all of another or its first `seconds`.
int FramesToShow(const motion::Library& library, int clip, double seconds);

// Runs the policy from the clip's first frame. Computes; errors: those of
// RunStarts, INVALID_ARGUMENT for seconds that are not positive.
absl::StatusOr<Recording> RecordClip(const Subject& subject, int clip,
                                     double seconds, const StopToken& stop);

// Runs the policy from the fallen state of that index, as EvaluateFallen
// (fallen_figures.h) does: beside a reference that stands at first, or, where
// `get_up` says so, with a get-up for a reference and then what the body goes
// on with, moved to where the body is. Computes; errors: those of
// RunStarts and of the starts (actor/fallen_evaluation.h), INVALID_ARGUMENT for
// an index that is none.
absl::StatusOr<Recording> RecordFallen(const Subject& subject, int state,
                                       bool get_up, const StopToken& stop);

}  // namespace sinew::evaluation

#endif  // SINEW_TOOLS_EVALUATION_RECORDING_H_
