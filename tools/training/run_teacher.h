#ifndef SINEW_TOOLS_TRAINING_RUN_TEACHER_H_
#define SINEW_TOOLS_TRAINING_RUN_TEACHER_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "common/policy/safetensors.h"
#include "common/rpc/credentials.h"
#include "common/stop.h"
#include "proto/sinew/v1/graph.pb.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/run.pb.h"
#include "teacher/client/annotator.h"
#include "tools/training/task_setup.h"

namespace sinew::tools {

// BundleSource.role of a teacher.
inline constexpr char kTeacherRole[] = "teacher";

// Who labels what a distillation's student sees (--teacher).
struct RunTeacher {
  std::unique_ptr<teacher::Annotator> annotator;
  // What the run's bundles say of it, a bundle each.
  std::vector<v1::RunInputs::Source> sources;
  // Whether evaluations say which of several labels what.
  bool by_evaluation = false;
  // Adds its policy to a student's graphs, for episodes in which it acts; empty
  // where the bundle is elsewhere, or one of several.
  std::function<absl::Status(v1::PolicyGraph&, TensorMap&)> add_graph;
};

struct RunTeacherOptions {
  // Each a bundle: a folder, which answers in this process, or addresses of
  // `sinew teacher`, HOST:PORT or unix:PATH, with commas between those of its
  // replicas. Of several, in any order, each labels its own clips
  // (teacher/clip_annotator.h), by name: those that its own training drew
  // starts from (CLIP_USE_TRAINED_ON); of a bundle of an old version, which
  // does not say, those that its task.start.only_clips names, if it is a
  // folder, else all that its provenance names (ChooseByTraining).
  std::vector<std::string> teachers;
  // Files of `sinew eval --out`, one of each of several bundles: each labels
  // the clips that it does best at instead (ChooseByEvaluation). One that does
  // best at none is no teacher.
  std::vector<std::string> evaluations = {};
  // How long to go on asking addresses without an answer, > 0.
  absl::Duration patience = absl::Minutes(2);
  // Of one call to an address, > 0.
  absl::Duration timeout = absl::Seconds(30);
  int threads = 1;  // of all bundles in this process; one works at a time
  rpc::Security security = {};
  StopToken stop = {};
};

// Unset where the recipe (defaults filled) has no distillation and there are no
// teachers. Checks that the teacher is of the task's character and control
// rate, observes nothing but what the student observes (maybe less:
// teacher/column_annotator.h) and places its targets as
// distillation.teacher_action says. Of several bundles, every clip that starts
// may be drawn from has one (teacher_choice.h), and its source names it.
//
// Thread-safety: a function. Blocking: reads the bundle, or asks the peers.
// Errors: INVALID_ARGUMENT: one of recipe and teachers without the other;
// something that does not fit, with bundle or peer, field, expected and found;
// those of ReadBundle, of teacher_choice.h, of ConnectAnnotator for addresses:
// UNAVAILABLE or DEADLINE_EXCEEDED where none of them answers, among others.
absl::StatusOr<std::optional<RunTeacher>> OpenTeacher(
    const RunTeacherOptions& options, const v1::Recipe& recipe,
    const TaskSetup& setup);

// The check, for a description that `name` gave: of each column that the
// teacher observes, which of the student's it is.
absl::StatusOr<std::vector<int32_t>> CheckTeacher(
    const std::string& name, const v1::DescribeTeacherResponse& teacher,
    const v1::Recipe& recipe, const TaskSetup& setup);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_RUN_TEACHER_H_
