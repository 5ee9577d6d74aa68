#ifndef SINEW_TOOLS_TRAINING_RUN_WITH_ACTORS_H_
#define SINEW_TOOLS_TRAINING_RUN_WITH_ACTORS_H_

#include <string>

#include "absl/status/statusor.h"
#include "common/clock.h"
#include "common/stop.h"
#include "tools/training/training_run.h"

namespace sinew::tools {

// Actors of a run as child processes on this machine.
struct LocalActors {
  int count = 1;
  // The `sinew` program that they are.
  std::string program = "/proc/self/exe";
};

// One run from opening to drain, with actors of its own, which share
// options.cores with the learner; ranks and address are chosen here. What
// `sinew train` does once, or once for each stage of a procedure.
//
// Blocking: until the run's end. Errors: those of TrainingRun and
// ActorProcesses.
absl::StatusOr<TrainingRun::Result> RunWithActors(TrainingRun::Options options,
                                                  const LocalActors& actors,
                                                  Clock& clock,
                                                  const StopToken& stop);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_RUN_WITH_ACTORS_H_
