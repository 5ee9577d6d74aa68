#ifndef SINEW_TOOLS_TRAINING_RUN_SOURCES_H_
#define SINEW_TOOLS_TRAINING_RUN_SOURCES_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "proto/sinew/v1/motion.pb.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/run.pb.h"
#include "proto/sinew/v1/snapshot.pb.h"
#include "tools/training/initial_policy.h"
#include "tools/training/run_teacher.h"

namespace sinew::tools {

// How a run goes on that has been begun.
struct Resumption {
  // What a compact state says that it goes on from; unset: the run's folder.
  std::optional<std::vector<v1::RunInputs::Source>> moved = std::nullopt;
  // From a compact state, or with another library, of which each teacher may
  // label other clips, and by evaluations others may teach.
  bool migrates = false;
};

// What a run's bundles are to say of those that it began with and learns from
// (RunInputs.sources): `initial`, then the teachers. Of a run that is resumed,
// in folder `run`, what they said so far, with the clips that each teacher
// labels now. `resumption`: unset for a new run.
//
// Thread-safety: a function. Blocking: on the disk. Errors: those of
// ReadBundle; FAILED_PRECONDITION for a resumed run that had other teachers, in
// whatever order, or another one of them for a clip, with the digests of both,
// or none where it has evaluations now; save as `migrates` says.
absl::StatusOr<std::vector<v1::RunInputs::Source>> RunSources(
    const std::string& run, const std::optional<Resumption>& resumption,
    const InitialPolicy& initial, const std::optional<RunTeacher>& teacher);

// Adds a source without a bundle to those of a run that is resumed: clips of
// its library that it drew starts from before, as the table of its state says,
// and that neither it nor a source draws from any more. None, nothing is added.
// So a bundle does not call a clip left out that its run was trained on with an
// earlier library. Pure.
void AddEarlierTraining(const v1::CurriculumTable& before,
                        const v1::Start& start,
                        const v1::MotionLibrary& library,
                        std::vector<v1::RunInputs::Source>* sources);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_RUN_SOURCES_H_
