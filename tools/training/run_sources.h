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

// What a run's bundles are to say of those that it began with and learns from
// (RunInputs.sources): `initial`, then the teachers. Of a run that is resumed,
// in folder `run`, what they said so far: `moved`, where it goes on from a
// compact state that has them, else what the folder says, with the clips that
// each teacher labels now.
//
// Thread-safety: a function. Blocking: on the disk. Errors: those of
// ReadBundle; FAILED_PRECONDITION for a resumed run that had other teachers, in
// whatever order, or another one of them for a clip, with the digests of both.
absl::StatusOr<std::vector<v1::RunInputs::Source>> RunSources(
    const std::string& run, bool resumed,
    const std::optional<std::vector<v1::RunInputs::Source>>& moved,
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
