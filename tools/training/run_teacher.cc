#include "tools/training/run_teacher.h"

#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/files.h"
#include "common/policy/teacher_graph.h"
#include "common/status_context.h"
#include "common/status_macros.h"
#include "deploy/bundle/clip_uses.h"
#include "deploy/bundle/run_export.h"
#include "proto/sinew/v1/bundle.pb.h"
#include "proto/sinew/v1/motion.pb.h"
#include "sim/motion/library.h"
#include "sim/world/start.h"
#include "teacher/client/remote_annotator.h"
#include "teacher/clip_annotator.h"
#include "teacher/local_annotator.h"
#include "teacher/teacher_policy.h"
#include "tools/teacher/read_teacher.h"
#include "tools/training/same_message.h"
#include "tools/training/teacher_choice.h"

namespace sinew::tools {
namespace {

constexpr char kTeacher[] = "teacher";

struct LocalTeacher {
  std::unique_ptr<teacher::LocalAnnotator> annotator;
  teacher::TeacherPolicy policy;
};

// On the threads of `beside`; null: on so many of its own.
absl::StatusOr<LocalTeacher> ReadLocal(
    const std::string& folder, int threads, const v1::Recipe& recipe,
    const TaskSetup& setup, const teacher::LocalAnnotator* beside = nullptr) {
  LocalTeacher result;
  SINEW_ASSIGN_OR_RETURN(result.policy, teacher::ReadTeacher(folder));
  SINEW_ASSIGN_OR_RETURN(
      result.annotator,
      beside == nullptr
          ? teacher::LocalAnnotator::Create(result.policy, threads)
          : teacher::LocalAnnotator::CreateBeside(*beside, result.policy));
  SINEW_RETURN_IF_ERROR(
      CheckTeacher(folder, result.annotator->description(), recipe, setup));
  return result;
}

v1::RunInputs::Source SourceOf(const v1::DescribeTeacherResponse& teacher) {
  return bundle::MakeSource(kTeacher, teacher.bundle_sha256(),
                            teacher.provenance());
}

absl::StatusOr<RunTeacher> OpenOne(const RunTeacherOptions& options,
                                   const v1::Recipe& recipe,
                                   const TaskSetup& setup) {
  SINEW_ASSIGN_OR_RETURN(
      LocalTeacher local,
      ReadLocal(options.teachers[0], options.threads, recipe, setup));
  RunTeacher result;
  result.sources = {SourceOf(local.annotator->description())};
  result.annotator = std::move(local.annotator);
  result.add_graph = [graph = std::move(local.policy.graph),
                      weights = std::move(local.policy.weights)](
                         v1::PolicyGraph& all, TensorMap& all_weights) {
    return policy::AddTeacherGraph(graph, weights, all, all_weights);
  };
  return result;
}

// Names of the clips that a bundle labels: those that its own training drew
// starts from; where it does not say, as bundles of old versions, those that
// its task names, if it does, else all that its provenance names.
std::set<std::string> ClipsOf(const v1::BundleManifest& manifest) {
  const bundle::ClipUses uses = bundle::ClipUsesOf(manifest.provenance());
  if (!uses.empty()) return bundle::TrainedOn(uses);
  const auto& only = manifest.task().start().only_clips();
  if (!only.empty()) return {only.begin(), only.end()};
  std::set<std::string> names;
  for (const std::string& clip : manifest.provenance().clips()) {
    names.emplace(bundle::ClipNameOf(clip));
  }
  return names;
}

// Writes down of each source what it labels: of the clips that starts are drawn
// from, those whose teacher it is.
void AddLabels(const TeacherOfClip& teacher_of_clip, const v1::Start& start,
               const motion::Library& library,
               std::vector<v1::RunInputs::Source>* sources) {
  for (int c = 0; c < library.num_clips(); ++c) {
    if (!world::IsDrawn(start, library.clip(c))) continue;
    (*sources)[teacher_of_clip[c]].add_labelled_clips(library.clip(c).name());
  }
}

absl::StatusOr<RunTeacher> OpenSeveral(const RunTeacherOptions& options,
                                       const v1::Recipe& recipe,
                                       const TaskSetup& setup) {
  RunTeacher result;
  std::vector<std::unique_ptr<teacher::Annotator>> teachers;
  std::vector<TeacherCandidate> candidates;
  const teacher::LocalAnnotator* first = nullptr;
  for (const std::string& folder : options.teachers) {
    SINEW_ASSIGN_OR_RETURN(
        LocalTeacher local,
        ReadLocal(folder, options.threads, recipe, setup, first));
    if (first == nullptr) first = local.annotator.get();
    result.sources.push_back(SourceOf(local.annotator->description()));
    candidates.push_back(
        {.folder = folder,
         .manifest_sha256 = local.annotator->description().bundle_sha256(),
         .clips = ClipsOf(local.policy.manifest)});
    teachers.push_back(std::move(local.annotator));
  }
  const v1::Start& start = recipe.task().start();
  SINEW_ASSIGN_OR_RETURN(
      TeacherOfClip teacher_of_clip,
      options.evaluations.empty()
          ? ChooseByTraining(candidates, start, *setup.library)
          : ChooseByEvaluation(candidates, options.evaluations,
                               *setup.library));
  AddLabels(teacher_of_clip, start, *setup.library, &result.sources);
  SINEW_ASSIGN_OR_RETURN(result.annotator,
                         teacher::ClipAnnotator::Create(
                             std::move(teachers), std::move(teacher_of_clip)));
  return result;
}

absl::StatusOr<RunTeacher> Connect(const RunTeacherOptions& options,
                                   const v1::Recipe& recipe,
                                   const TaskSetup& setup) {
  teacher::RemoteAnnotatorOptions remote;
  remote.addresses = options.teachers;
  remote.patience = options.patience;
  remote.call_timeout = options.timeout;
  remote.security = options.security;
  remote.stop = options.stop;
  RunTeacher result;
  SINEW_ASSIGN_OR_RETURN(result.annotator, teacher::ConnectAnnotator(remote));
  const v1::DescribeTeacherResponse& teacher = result.annotator->description();
  SINEW_RETURN_IF_ERROR(CheckTeacher(absl::StrJoin(options.teachers, ", "),
                                     teacher, recipe, setup));
  result.sources = {SourceOf(teacher)};
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
  std::vector<std::string> folders, others;
  for (const std::string& name : options.teachers) {
    (FileExists(name) ? folders : others).push_back(name);
  }
  if (!options.evaluations.empty() && folders.size() < 2) {
    return absl::InvalidArgumentError(absl::StrCat(
        "--teacher-eval: expected none unless --teacher has several bundles to "
        "choose from, found ",
        absl::StrJoin(options.evaluations, ", ")));
  }
  if (options.teachers.empty()) return std::nullopt;
  if (!folders.empty() && !others.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "--teacher: expected bundles' folders or addresses, found folders (",
        absl::StrJoin(folders, ", "), ") and what is none (",
        absl::StrJoin(others, ", "), ")"));
  }
  const bool one = folders.size() == 1;
  if (recipe.distillation().teacher_share() > 0 && !one) {
    return absl::InvalidArgumentError(absl::StrCat(
        "recipe field distillation.teacher_share: expected 0 or one bundle's "
        "folder in --teacher, which actors can act by, found ",
        recipe.distillation().teacher_share(), " and ",
        absl::StrJoin(options.teachers, ", ")));
  }
  const auto open = one ? OpenOne : folders.empty() ? Connect : OpenSeveral;
  SINEW_ASSIGN_OR_RETURN(RunTeacher result, open(options, recipe, setup));
  if (recipe.distillation().teacher_share() == 0) result.add_graph = nullptr;
  return result;
}

absl::Status CheckTeacher(const std::string& name,
                          const v1::DescribeTeacherResponse& teacher,
                          const v1::Recipe& recipe, const TaskSetup& setup) {
  if (teacher.control_hz() == 0) {
    return absl::InvalidArgumentError(absl::StrCat(
        name, ": control_hz: expected ", recipe.physics().control_hz(),
        ", found none: a `sinew teacher` of an older version?"));
  }
  // A step of the teacher's must last as long as the student's.
  SINEW_RETURN_IF_ERROR(
      WithContext(SameValue("control_hz", recipe.physics().control_hz(),
                            teacher.control_hz()),
                  name));
  SINEW_RETURN_IF_ERROR(
      WithContext(SameValue("character_sha256", setup.character_sha256,
                            teacher.character_sha256()),
                  name));
  SINEW_RETURN_IF_ERROR(
      WithContext(SameMessage("observation", recipe.task().observation(),
                              teacher.observation()),
                  name));
  SINEW_RETURN_IF_ERROR(WithContext(
      SameValue<int64_t>("observation_width", setup.observation_width,
                         teacher.observation_width()),
      name));
  SINEW_RETURN_IF_ERROR(
      WithContext(SameValue<int64_t>("action_width", setup.action_width,
                                     teacher.action_width()),
                  name));
  return WithContext(
      SameMessage("action (distillation.teacher_action)",
                  recipe.distillation().teacher_action(), teacher.action()),
      name);
}

}  // namespace sinew::tools
