#ifndef SINEW_TOOLS_CURRICULUM_RUN_CURRICULUM_H_
#define SINEW_TOOLS_CURRICULUM_RUN_CURRICULUM_H_

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/clock.h"
#include "common/rpc/credentials.h"
#include "common/stop.h"
#include "learner/curriculum/curriculum_summary.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/snapshot.pb.h"

namespace sinew::tools {

// Where the episodes of a run start, as its newest training state has it.
struct RunCurriculum {
  std::string run;
  int64_t iteration = 0;
  int64_t samples = 0;
  v1::Start start;                // of its recipe, defaults filled
  double frames_per_second = 30;  // of its library
  v1::CurriculumTable table;
  learner::CurriculumSummary summary;
  // Newer states that were passed over since they are damaged.
  std::vector<std::string> warnings;
};

// Where the training states of a run are.
struct StateStore {
  std::string where;  // as in checkpoint::OpenStore; empty: RUN/checkpoints
  rpc::Security security;
  StopToken stop = {};
};

// Reads a run directory, also while training goes on. Blocks on the disk, or
// until the store answers. NOT_FOUND: it is no run directory, or there is no
// training state yet; INVALID_ARGUMENT: its recipe; FAILED_PRECONDITION: the
// states are of another recipe; DATA_LOSS: all are damaged; those of the store.
absl::StatusOr<RunCurriculum> ReadRunCurriculum(const std::string& run,
                                                const Clock& clock,
                                                const StateStore& states = {});

// As JSON:
//
//   run, iteration, samples, rule ("adaptive_bins"), bin_seconds
//   summary   clips, left_out_clips, drawn_clips, bins, entropy, entropy_share,
//             floor_share, largest_clip_share, clips_of_half, failure_rate,
//             hardest_share, hardest_failure_rate, evaluated_clips, hard_clips,
//             worst_success
//   clips     the `hardest` ones that starts are drawn from, hardest first:
//             name, visits, failures, failure_rate, probability,
//             tracking_error_mm (of a bin: mean body distance of about the
//             last ten episodes that began there, null: none did; of a clip:
//             the mean over its bins by the episodes that began in each),
//             last_seen, evaluations, failed_evaluations, failed_latest,
//             succeeded_share, mean_error_mm (the last three null: never
//             evaluated)
//   bins      the `hardest` ones: clip, from_s, to_s, visits, failures,
//             recent_passages, recent_failures, failure_rate, probability,
//             tracking_error_mm, last_seen
//   left_out  evaluated clips that are left out: name, evaluations,
//             failed_evaluations, failed_latest, succeeded_share,
//             mean_error_mm
//
// Pure.
nlohmann::ordered_json CurriculumJson(const RunCurriculum& curriculum,
                                      int hardest);

// The same for people, as a page of text. Pure.
std::string CurriculumText(const RunCurriculum& curriculum, int hardest);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_CURRICULUM_RUN_CURRICULUM_H_
