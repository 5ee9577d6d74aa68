#ifndef SINEW_TOOLS_TRAINING_RUN_SOURCES_H_
#define SINEW_TOOLS_TRAINING_RUN_SOURCES_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "proto/sinew/v1/run.pb.h"
#include "tools/training/initial_policy.h"
#include "tools/training/run_teacher.h"

namespace sinew::tools {

// What a run's bundles are to say of those that it began with and learns from
// (RunInputs.sources): `initial`, then the teachers. Of a run that is resumed,
// in folder `run`, what they said so far: `moved`, where it goes on from a
// compact state that has them, else what the folder says.
//
// Thread-safety: a function. Blocking: on the disk. Errors: those of
// ReadBundle; FAILED_PRECONDITION for a resumed run that had other teachers, in
// whatever order, with the digests of both.
absl::StatusOr<std::vector<v1::RunInputs::Source>> RunSources(
    const std::string& run, bool resumed,
    const std::optional<std::vector<v1::RunInputs::Source>>& moved,
    const InitialPolicy& initial, const std::optional<RunTeacher>& teacher);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_RUN_SOURCES_H_
