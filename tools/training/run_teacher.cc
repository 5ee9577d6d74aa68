#include "tools/training/run_teacher.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/files.h"
#include "common/policy/teacher_graph.h"
#include "common/status_macros.h"
#include "deploy/bundle/run_export.h"
#include "teacher/client/remote_annotator.h"
#include "teacher/local_annotator.h"
#include "teacher/teacher_policy.h"
#include "tools/teacher/read_teacher.h"
#include "tools/training/same_message.h"

namespace sinew::tools {
namespace {

constexpr char kTeacher[] = "teacher";

absl::StatusOr<RunTeacher> ReadLocal(const std::string& folder, int threads) {
  SINEW_ASSIGN_OR_RETURN(teacher::TeacherPolicy expert,
                         teacher::ReadTeacher(folder));
  RunTeacher result;
  SINEW_ASSIGN_OR_RETURN(result.annotator,
                         teacher::LocalAnnotator::Create(expert, threads));
  result.add_graph = [graph = std::move(expert.graph),
                      weights = std::move(expert.weights)](
                         v1::PolicyGraph& all, TensorMap& all_weights) {
    return policy::AddTeacherGraph(graph, weights, all, all_weights);
  };
  return result;
}

absl::StatusOr<RunTeacher> Connect(const RunTeacherOptions& options) {
  teacher::RemoteAnnotatorOptions remote;
  remote.addresses = options.teachers;
  remote.patience = options.patience;
  remote.security = options.security;
  remote.stop = options.stop;
  RunTeacher result;
  SINEW_ASSIGN_OR_RETURN(result.annotator, teacher::ConnectAnnotator(remote));
  return result;
}

}  // namespace

absl::StatusOr<std::optional<RunTeacher>> OpenTeacher(
    const RunTeacherOptions& options, const v1::Recipe& recipe,
    const TaskSetup& setup) {
  if (recipe.has_distillation() == options.teachers.empty()) {
    return absl::InvalidArgumentError(
        recipe.has_distillation()
            ? "--teacher: expected a bundle or addresses, since the recipe has "
              "distillation, found none"
            : "--teacher: expected none, since the recipe has no distillation, "
              "found one");
  }
  if (options.teachers.empty()) return std::nullopt;
  const bool local =
      options.teachers.size() == 1 && FileExists(options.teachers[0]);
  if (recipe.distillation().teacher_share() > 0 && !local) {
    return absl::InvalidArgumentError(absl::StrCat(
        "recipe field distillation.teacher_share: expected 0 or a bundle's "
        "folder in --teacher, which actors can act by, found ",
        recipe.distillation().teacher_share(), " and ",
        absl::StrJoin(options.teachers, ", ")));
  }
  RunTeacher result;
  if (local) {
    SINEW_ASSIGN_OR_RETURN(result,
                           ReadLocal(options.teachers[0], options.threads));
  } else {
    SINEW_ASSIGN_OR_RETURN(result, Connect(options));
  }
  const v1::DescribeTeacherResponse& teacher = result.annotator->description();
  SINEW_RETURN_IF_ERROR(CheckTeacher(absl::StrJoin(options.teachers, ", "),
                                     teacher, recipe, setup));
  result.source = bundle::MakeSource(kTeacher, teacher.bundle_sha256(),
                                     teacher.provenance());
  if (recipe.distillation().teacher_share() == 0) result.add_graph = nullptr;
  return result;
}

absl::Status CheckTeacher(const std::string& name,
                          const v1::DescribeTeacherResponse& teacher,
                          const v1::Recipe& recipe, const TaskSetup& setup) {
  // A step of the teacher's must last as long as the student's.
  SINEW_RETURN_IF_ERROR(
      In(name, SameValue("control_hz", recipe.physics().control_hz(),
                         teacher.control_hz())));
  SINEW_RETURN_IF_ERROR(
      In(name, SameValue("character_sha256", setup.character_sha256,
                         teacher.character_sha256())));
  SINEW_RETURN_IF_ERROR(
      In(name, SameMessage("observation", recipe.task().observation(),
                           teacher.observation())));
  SINEW_RETURN_IF_ERROR(
      In(name, SameValue<int64_t>("observation_width", setup.observation_width,
                                  teacher.observation_width())));
  SINEW_RETURN_IF_ERROR(
      In(name, SameValue<int64_t>("action_width", setup.action_width,
                                  teacher.action_width())));
  return In(name, SameMessage("action (distillation.teacher_action)",
                              recipe.distillation().teacher_action(),
                              teacher.action()));
}

}  // namespace sinew::tools
