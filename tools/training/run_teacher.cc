#include "tools/training/run_teacher.h"

#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "common/files.h"
#include "common/policy/teacher_graph.h"
#include "common/rpc/address.h"
#include "common/status_context.h"
#include "common/status_macros.h"
#include "deploy/bundle/clip_uses.h"
#include "deploy/bundle/run_export.h"
#include "proto/sinew/v1/bundle.pb.h"
#include "sim/motion/library.h"
#include "sim/world/observation.h"
#include "sim/world/start.h"
#include "teacher/client/annotator.h"
#include "teacher/client/remote_annotator.h"
#include "teacher/clip_annotator.h"
#include "teacher/column_annotator.h"
#include "teacher/local_annotator.h"
#include "teacher/teacher_policy.h"
#include "tools/teacher/read_teacher.h"
#include "tools/training/same_message.h"
#include "tools/training/teacher_choice.h"

namespace sinew::tools {
namespace {

// Between addresses of replicas.
constexpr char kAmongReplicas[] = ",";

struct LocalTeacher {
  std::unique_ptr<teacher::Annotator> annotator;
  // Of the annotator; another bundle's works on its threads.
  const teacher::LocalAnnotator* threads = nullptr;
  teacher::TeacherPolicy policy;
};

bool SeesAll(absl::Span<const int32_t> columns, int64_t width) {
  for (size_t i = 0; i < columns.size(); ++i) {
    if (columns[i] != static_cast<int32_t>(i)) return false;
  }
  return static_cast<int64_t>(columns.size()) == width;
}

// The teacher, shown what it observes of what the student observes.
absl::StatusOr<std::unique_ptr<teacher::Annotator>> Fit(
    const std::string& name, std::unique_ptr<teacher::Annotator> teacher,
    const v1::Recipe& recipe, const TaskSetup& setup) {
  SINEW_ASSIGN_OR_RETURN(
      std::vector<int32_t> columns,
      CheckTeacher(name, teacher->description(), recipe, setup));
  if (SeesAll(columns, setup.observation_width)) return teacher;
  if (const double share = recipe.distillation().teacher_share(); share > 0) {
    return absl::InvalidArgumentError(absl::StrCat(
        "recipe field distillation.teacher_share: expected 0, since ", name,
        " does not observe all that the student does in its order, found ",
        share));
  }
  return teacher::ColumnAnnotator::Create(
      std::move(teacher), std::move(columns), setup.observation_width);
}

// On the threads of `beside`; null: on so many of its own.
absl::StatusOr<LocalTeacher> ReadLocal(
    const std::string& folder, int threads, const v1::Recipe& recipe,
    const TaskSetup& setup, const teacher::LocalAnnotator* beside = nullptr) {
  LocalTeacher result;
  SINEW_ASSIGN_OR_RETURN(result.policy, teacher::ReadTeacher(folder));
  SINEW_ASSIGN_OR_RETURN(
      std::unique_ptr<teacher::LocalAnnotator> annotator,
      beside == nullptr
          ? teacher::LocalAnnotator::Create(result.policy, threads)
          : teacher::LocalAnnotator::CreateBeside(*beside, result.policy));
  result.threads = annotator.get();
  SINEW_ASSIGN_OR_RETURN(result.annotator,
                         Fit(folder, std::move(annotator), recipe, setup));
  return result;
}

v1::RunInputs::Source SourceOf(const v1::DescribeTeacherResponse& teacher) {
  return bundle::MakeSource(kTeacherRole, teacher.bundle_sha256(),
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
// its task names, if that is known, else all that its provenance names.
std::set<std::string> ClipsOf(const v1::BundleProvenance& provenance,
                              const v1::Start& start) {
  const bundle::ClipUses uses = bundle::ClipUsesOf(provenance);
  if (!uses.empty()) return bundle::TrainedOn(uses);
  const auto& only = start.only_clips();
  if (!only.empty()) return {only.begin(), only.end()};
  std::set<std::string> names;
  for (const std::string& clip : provenance.clips()) {
    names.emplace(bundle::ClipNameOf(clip));
  }
  return names;
}

// Several bundles, each of which labels its own clips.
class Several {
 public:
  // INVALID_ARGUMENT: a bundle that is among them already.
  absl::Status Add(const std::string& name, std::set<std::string> clips,
                   std::unique_ptr<teacher::Annotator> annotator,
                   bool elsewhere) {
    const v1::DescribeTeacherResponse& teacher = annotator->description();
    for (const TeacherCandidate& other : candidates_) {
      if (other.manifest_sha256 != teacher.bundle_sha256()) continue;
      return absl::InvalidArgumentError(
          absl::StrCat("--teacher: expected several bundles, found the same (",
                       "manifest_sha256 ", other.manifest_sha256, ") as ",
                       other.name, " and as ", name,
                       "; addresses of its replicas have commas between them"));
    }
    sources_.push_back(SourceOf(teacher));
    candidates_.push_back({.name = name,
                           .manifest_sha256 = teacher.bundle_sha256(),
                           .clips = std::move(clips)});
    teachers_.push_back(
        {.annotator = std::move(annotator), .elsewhere = elsewhere});
    return absl::OkStatus();
  }

  absl::StatusOr<RunTeacher> Divide(const RunTeacherOptions& options,
                                    const v1::Start& start,
                                    const motion::Library& library) && {
    RunTeacher result;
    result.by_evaluation = !options.evaluations.empty();
    SINEW_ASSIGN_OR_RETURN(
        TeacherOfClip teacher_of_clip,
        result.by_evaluation
            ? ChooseByEvaluation(candidates_, options.evaluations, library)
            : ChooseByTraining(candidates_, start, library));
    for (int c = 0; c < library.num_clips(); ++c) {
      if (!world::IsDrawn(start, library.clip(c))) continue;
      sources_[teacher_of_clip[c]].add_labelled_clips(library.clip(c).name());
    }
    // By evaluation, what is no teacher of anything is not one of the student.
    std::vector<teacher::ClipTeacher> kept;
    std::vector<int> place(teachers_.size(), teacher::ClipAnnotator::kNone);
    for (size_t t = 0; t < teachers_.size(); ++t) {
      const bool idle = sources_[t].labelled_clips().empty();
      if (result.by_evaluation && idle) continue;
      place[t] = static_cast<int>(kept.size());
      kept.push_back(std::move(teachers_[t]));
      result.sources.push_back(std::move(sources_[t]));
    }
    for (int& t : teacher_of_clip) {
      if (t != teacher::ClipAnnotator::kNone) t = place[t];
    }
    SINEW_ASSIGN_OR_RETURN(result.annotator,
                           teacher::ClipAnnotator::Create(
                               std::move(kept), std::move(teacher_of_clip)));
    return result;
  }

 private:
  std::vector<v1::RunInputs::Source> sources_;
  std::vector<TeacherCandidate> candidates_;
  std::vector<teacher::ClipTeacher> teachers_;
};

// A teacher elsewhere, by its replicas' addresses.
absl::StatusOr<std::unique_ptr<teacher::Annotator>> Connect(
    const std::string& addresses, const RunTeacherOptions& options,
    const v1::Recipe& recipe, const TaskSetup& setup) {
  teacher::RemoteAnnotatorOptions remote;
  remote.addresses = absl::StrSplit(addresses, kAmongReplicas);
  remote.patience = options.patience;
  remote.call_timeout = options.timeout;
  remote.security = options.security;
  remote.stop = options.stop;
  SINEW_ASSIGN_OR_RETURN(auto result, teacher::ConnectAnnotator(remote));
  return Fit(addresses, std::move(result), recipe, setup);
}

absl::StatusOr<RunTeacher> OpenElsewhere(const RunTeacherOptions& options,
                                         const v1::Recipe& recipe,
                                         const TaskSetup& setup) {
  RunTeacher result;
  SINEW_ASSIGN_OR_RETURN(result.annotator,
                         Connect(options.teachers[0], options, recipe, setup));
  result.sources = {SourceOf(result.annotator->description())};
  return result;
}

absl::StatusOr<RunTeacher> OpenSeveral(const RunTeacherOptions& options,
                                       const v1::Recipe& recipe,
                                       const TaskSetup& setup) {
  Several several;
  const teacher::LocalAnnotator* first = nullptr;
  for (const std::string& name : options.teachers) {
    if (!FileExists(name)) {
      SINEW_ASSIGN_OR_RETURN(auto elsewhere,
                             Connect(name, options, recipe, setup));
      std::set<std::string> clips =
          ClipsOf(elsewhere->description().provenance(), {});
      SINEW_RETURN_IF_ERROR(several.Add(name, std::move(clips),
                                        std::move(elsewhere),
                                        /*elsewhere=*/true));
      continue;
    }
    SINEW_ASSIGN_OR_RETURN(LocalTeacher local, ReadLocal(name, options.threads,
                                                         recipe, setup, first));
    if (first == nullptr) first = local.threads;
    const v1::BundleManifest& manifest = local.policy.manifest;
    SINEW_RETURN_IF_ERROR(several.Add(
        name, ClipsOf(manifest.provenance(), manifest.task().start()),
        std::move(local.annotator), /*elsewhere=*/false));
  }
  return std::move(several).Divide(options, recipe.task().start(),
                                   *setup.library);
}

// That what is no folder could be addresses; asks nobody.
absl::Status CheckNames(const std::vector<std::string>& teachers) {
  for (const std::string& name : teachers) {
    if (FileExists(name)) continue;
    for (const absl::string_view one : absl::StrSplit(name, kAmongReplicas)) {
      const absl::Status parsed = rpc::ParseAddress(std::string(one)).status();
      if (parsed.ok()) continue;
      return absl::InvalidArgumentError(absl::StrCat(
          "--teacher ", name,
          ": expected the folder of a bundle, which is not there, or addresses "
          "with commas between, found: ",
          parsed.message()));
    }
  }
  return absl::OkStatus();
}

// Which columns of the student's observation are the teacher's.
absl::StatusOr<std::vector<int32_t>> ObservedColumns(
    const std::string& name, const v1::DescribeTeacherResponse& teacher,
    const v1::Recipe& recipe, const TaskSetup& setup) {
  absl::StatusOr<world::ObservationBuilder> seen =
      setup.observation->ForSameCharacter(teacher.observation());
  if (!seen.ok()) {
    return WithContext(seen.status(), absl::StrCat(name, ": its observation"));
  }
  SINEW_RETURN_IF_ERROR(
      WithContext(SameValue<int64_t>("observation_width", seen->width(),
                                     teacher.observation_width()),
                  name));
  std::optional<std::vector<int32_t>> columns =
      setup.observation->ColumnsOf(*seen);
  if (columns.has_value()) return *std::move(columns);
  return WithContext(
      Unfit("observation",
            absl::StrCat("blocks and frames among the recipe's, ",
                         recipe.task().observation().ShortDebugString()),
            teacher.observation().ShortDebugString()),
      name);
}

}  // namespace

absl::StatusOr<std::optional<RunTeacher>> OpenTeacher(
    const RunTeacherOptions& options, const v1::Recipe& recipe,
    const TaskSetup& setup) {
  if (recipe.has_distillation() == options.teachers.empty()) {
    return absl::InvalidArgumentError(
        recipe.has_distillation()
            ? "--teacher: expected a bundle or its addresses, since the "
              "recipe has distillation, found none"
            : "--teacher: expected none, since the recipe has no distillation, "
              "found one");
  }
  if (options.teachers.size() < 2 && !options.evaluations.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "--teacher-eval: expected none unless --teacher has several bundles to "
        "choose from, found ",
        absl::StrJoin(options.evaluations, ", ")));
  }
  if (options.teachers.empty()) return std::nullopt;
  SINEW_RETURN_IF_ERROR(CheckNames(options.teachers));
  const bool one = options.teachers.size() == 1;
  const bool here = FileExists(options.teachers[0]);
  if (recipe.distillation().teacher_share() > 0 && !(one && here)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "recipe field distillation.teacher_share: expected 0 or one bundle's "
        "folder in --teacher, which actors can act by, found ",
        recipe.distillation().teacher_share(), " and ",
        absl::StrJoin(options.teachers, ", ")));
  }
  const auto open = !one ? OpenSeveral : here ? OpenOne : OpenElsewhere;
  SINEW_ASSIGN_OR_RETURN(RunTeacher result, open(options, recipe, setup));
  if (recipe.distillation().teacher_share() == 0) result.add_graph = nullptr;
  return result;
}

absl::StatusOr<std::vector<int32_t>> CheckTeacher(
    const std::string& name, const v1::DescribeTeacherResponse& teacher,
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
      WithContext(SameValue<int64_t>("action_width", setup.action_width,
                                     teacher.action_width()),
                  name));
  SINEW_RETURN_IF_ERROR(WithContext(
      SameMessage("action (distillation.teacher_action)",
                  recipe.distillation().teacher_action(), teacher.action()),
      name));
  return ObservedColumns(name, teacher, recipe, setup);
}

}  // namespace sinew::tools
