#ifndef SINEW_TOOLS_TRAINING_TEACHER_CHOICE_H_
#define SINEW_TOOLS_TRAINING_TEACHER_CHOICE_H_

#include <set>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "sim/motion/library.h"

namespace sinew::tools {

// Which of several bundles teaches which clip of a library: by what they were
// trained on, or by how well they do.
//
// Thread-safety: functions. Ownership: none.

// A bundle that may teach.
struct TeacherCandidate {
  std::string name;             // its folder, or where it is served
  std::string manifest_sha256;  // of its manifest.json
  // Names of the clips that it is to label by its training (run_teacher.h).
  std::set<std::string> clips = {};
};

// [clips of the library]: indices into the candidates; ClipAnnotator::kNone
// where there is none, which may only be of clips that no start is drawn from.
using TeacherOfClip = std::vector<int>;

// Of those that were trained on a clip the one that was trained on fewest
// clips: a policy of one clip goes before one of its family. Pure.
//
// INVALID_ARGUMENT: a clip that starts may be drawn from and none was trained
// on, or two of equally many clips.
absl::StatusOr<TeacherOfClip> ChooseByTraining(
    absl::Span<const TeacherCandidate> candidates, const v1::Start& start,
    const motion::Library& library);

// Of all candidates the one that wins most of a clip's starts; of equals, the
// one whose starts survive more frames in all, then the one of least E_g-mpjpe
// until the falls, then the first by digest, so that no order matters.
// `evaluations`: files of `sinew eval --out`, one of each candidate, all on
// this library with the same starts. Blocking: reads them.
//
// Errors, with file, field, what was expected and what was found:
// INVALID_ARGUMENT: a file that is none, of another bundle, of another library,
// that asked something else than the first (evaluation/same_task.h), two of one
// bundle, a bundle without one; those of ReadFile.
absl::StatusOr<TeacherOfClip> ChooseByEvaluation(
    absl::Span<const TeacherCandidate> candidates,
    absl::Span<const std::string> evaluations, const motion::Library& library);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_TEACHER_CHOICE_H_
