#include "tools/training/run_sources.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/logging.h"
#include "common/status_macros.h"
#include "deploy/bundle/clip_uses.h"
#include "deploy/bundle/run_export.h"
#include "proto/sinew/v1/bundle.pb.h"
#include "sim/world/start.h"

namespace sinew::tools {
namespace {

using Sources = std::vector<v1::RunInputs::Source>;

// Whether they say what each teacher labels: of several, and not in runs of
// old.
bool SayLabels(const Sources& sources) {
  return std::ranges::any_of(sources, [](const auto& source) {
    return !source.labelled_clips().empty();
  });
}

// Digests of the teachers among them, or of those that label something; labels
// do not depend on their order.
std::string Teachers(const Sources& sources, bool labelling) {
  std::vector<std::string> digests;
  for (const v1::RunInputs::Source& source : sources) {
    if (source.bundle().role() != kTeacherRole) continue;
    if (labelling && source.labelled_clips().empty()) continue;
    digests.push_back(source.bundle().manifest_sha256());
  }
  std::sort(digests.begin(), digests.end());
  return absl::StrJoin(digests, ", ");
}

// By clip, the digest of the teacher that labels it.
std::map<std::string, std::string> LabellersOf(const Sources& sources) {
  std::map<std::string, std::string> result;
  for (const v1::RunInputs::Source& source : sources) {
    for (const std::string& clip : source.labelled_clips()) {
      result[clip] = source.bundle().manifest_sha256();
    }
  }
  return result;
}

// A teacher that a run had before its library changed stays among its sources,
// and labels nothing; in a run of old, none says what it labels.
absl::Status CheckSameTeacher(const Sources& before, const Sources& teachers) {
  const bool say = SayLabels(before);
  const std::string expected = Teachers(before, say);
  const std::string found = Teachers(teachers, say && SayLabels(teachers));
  if (expected.empty() || expected == found) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat("--teacher: expected what the run was started with "
                   "(manifest_sha256 ",
                   expected, "), found another (", found,
                   "); give the same, or another --run"));
}

absl::Status CheckSameLabels(const Sources& before, const RunTeacher& teacher) {
  const auto expected = LabellersOf(before);
  const auto found = LabellersOf(teacher.sources);
  // A run of old does not say who labels what, but it had no evaluations.
  if (expected.empty() && teacher.by_evaluation) {
    return absl::FailedPreconditionError(
        "--teacher-eval: expected none, since the run was started without, "
        "found some; give the same, or another --run");
  }
  for (const auto& [clip, digest] : expected) {
    const auto same = found.find(clip);
    if (same == found.end() || same->second == digest) continue;
    return absl::FailedPreconditionError(absl::StrCat(
        "--teacher-eval: expected for clip ", clip,
        " the teacher that the run was started with (manifest_sha256 ", digest,
        "), found ", same->second,
        "; give the same evaluations, or another --run"));
  }
  return absl::OkStatus();
}

absl::Status CheckSame(const Sources& before, const RunTeacher& teacher,
                       bool migrates) {
  // Of another library, others may do best.
  if (!migrates || !teacher.by_evaluation) {
    SINEW_RETURN_IF_ERROR(CheckSameTeacher(before, teacher.sources));
  }
  return migrates ? absl::OkStatus() : CheckSameLabels(before, teacher);
}

// Which teacher labels which clips, as it is now: those of a library that has
// changed (--migrate-library) are others, and so may be their teachers.
void TakeLabels(const Sources& teachers, Sources* sources) {
  for (v1::RunInputs::Source& source : *sources) {
    if (source.bundle().role() == kTeacherRole) source.clear_labelled_clips();
  }
  for (const v1::RunInputs::Source& teacher : teachers) {
    const auto same = std::ranges::find_if(*sources, [&](const auto& source) {
      return source.bundle().role() == kTeacherRole &&
             source.bundle().manifest_sha256() ==
                 teacher.bundle().manifest_sha256();
    });
    if (same == sources->end()) {
      sources->push_back(teacher);
    } else {
      *same->mutable_labelled_clips() = teacher.labelled_clips();
    }
  }
}

// What was said so far; unset where it cannot be read.
std::optional<Sources> SourcesBefore(const std::string& run,
                                     const std::optional<Sources>& moved) {
  if (moved) return moved;
  const auto inputs = bundle::ReadRunInputs(run);
  if (inputs.ok()) {
    return Sources(inputs->sources().begin(), inputs->sources().end());
  }
  LogWarning("what the run began with cannot be read",
             {{"reason", inputs.status().message()}});
  return std::nullopt;
}

// Names of the clips that starts were drawn from.
std::set<std::string> DrawnBefore(const v1::CurriculumTable& table,
                                  const v1::Start& start) {
  std::set<std::string> names;
  for (const v1::CurriculumTable::Clip& clip : table.clips()) {
    v1::ClipInfo info;
    info.set_name(clip.name());
    info.set_left_out(clip.left_out());
    if (world::IsDrawn(start, info)) names.insert(clip.name());
  }
  return names;
}

}  // namespace

absl::StatusOr<Sources> RunSources(const std::string& run,
                                   const std::optional<Resumption>& resumption,
                                   const InitialPolicy& initial,
                                   const std::optional<RunTeacher>& teacher) {
  if (resumption) {
    std::optional<Sources> before = SourcesBefore(run, resumption->moved);
    if (before && teacher) {
      SINEW_RETURN_IF_ERROR(CheckSame(*before, *teacher, resumption->migrates));
      TakeLabels(teacher->sources, &*before);
    }
    if (before) return *std::move(before);
  }
  SINEW_ASSIGN_OR_RETURN(Sources sources, InitialSources(initial));
  if (teacher) {
    sources.insert(sources.end(), teacher->sources.begin(),
                   teacher->sources.end());
  }
  return sources;
}

void AddEarlierTraining(const v1::CurriculumTable& before,
                        const v1::Start& start,
                        const v1::MotionLibrary& library, Sources* sources) {
  const std::set<std::string> drawn = DrawnBefore(before, start);
  const bundle::ClipUses uses = bundle::ClipUsesOfRun(start, library, *sources);
  v1::RunInputs::Source earlier;
  for (const v1::ClipInfo& clip : library.clips()) {
    if (!drawn.contains(clip.name())) continue;
    const auto use = uses.find(std::string(bundle::ClipNameOf(clip.name())));
    if (use->second == v1::CLIP_USE_TRAINED_ON ||
        use->second == v1::CLIP_USE_SOURCE_TRAINED_ON) {
      continue;
    }
    earlier.add_clips(bundle::ClipEntryOf(clip));
    earlier.add_clip_uses(v1::CLIP_USE_TRAINED_ON);
  }
  if (earlier.clips_size() > 0) sources->push_back(std::move(earlier));
}

}  // namespace sinew::tools
