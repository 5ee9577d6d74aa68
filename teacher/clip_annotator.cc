#include "teacher/clip_annotator.h"

#include <algorithm>
#include <string>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/digest.h"
#include "common/status_context.h"
#include "common/status_macros.h"
#include "teacher/client/rows.h"

namespace sinew::teacher {
namespace {

absl::Status CheckTeachers(absl::Span<const ClipTeacher> teachers) {
  if (teachers.empty()) {
    return absl::InvalidArgumentError("teachers: expected some, found none");
  }
  const v1::DescribeTeacherResponse& first =
      teachers[0].annotator->description();
  for (const ClipTeacher& teacher : teachers) {
    const v1::DescribeTeacherResponse& other = teacher.annotator->description();
    if (other.observation_width() == first.observation_width() &&
        other.action_width() == first.action_width()) {
      continue;
    }
    return absl::InvalidArgumentError(absl::StrCat(
        "teacher ", other.bundle_sha256(), ": expected ",
        first.observation_width(), " observation and ", first.action_width(),
        " action columns as teacher ", first.bundle_sha256(), " has, found ",
        other.observation_width(), " and ", other.action_width()));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::unique_ptr<ClipAnnotator>> ClipAnnotator::Create(
    std::vector<ClipTeacher> teachers, std::vector<int> teacher_of_clip) {
  SINEW_RETURN_IF_ERROR(CheckTeachers(teachers));
  const auto count = static_cast<int>(teachers.size());
  for (size_t clip = 0; clip < teacher_of_clip.size(); ++clip) {
    const int teacher = teacher_of_clip[clip];
    if (teacher == kNone || (teacher >= 0 && teacher < count)) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("clip ", clip, ": expected one of ", count,
                     " teachers, found index ", teacher));
  }
  return std::unique_ptr<ClipAnnotator>(
      new ClipAnnotator(std::move(teachers), std::move(teacher_of_clip)));
}

ClipAnnotator::ClipAnnotator(std::vector<ClipTeacher> teachers,
                             std::vector<int> teacher_of_clip)
    : teachers_(std::move(teachers)),
      teacher_of_clip_(std::move(teacher_of_clip)),
      description_(teachers_[0].annotator->description()),
      spread_(teachers_[0].annotator->spread().begin(),
              teachers_[0].annotator->spread().end()) {
  std::string digests;
  for (const ClipTeacher& teacher : teachers_) {
    const v1::DescribeTeacherResponse& one = teacher.annotator->description();
    absl::StrAppend(&digests, one.bundle_sha256(), "\n");
    description_.set_max_rows(
        std::min(description_.max_rows(), one.max_rows()));
    for (size_t j = 0; j < spread_.size(); ++j) {
      spread_[j] = std::max(spread_[j], teacher.annotator->spread()[j]);
    }
  }
  description_.set_bundle_sha256(Sha256Hex(digests));
  description_.clear_provenance();
}

absl::Status ClipAnnotator::Annotate(const Rows& rows,
                                     absl::Span<double> targets) {
  SINEW_ASSIGN_OR_RETURN(const int64_t count,
                         CheckRows(description_, rows, targets));
  if (static_cast<int64_t>(rows.clips.size()) != count) {
    return absl::InvalidArgumentError(
        absl::StrCat("clips: expected one of each of ", count, " rows, found ",
                     rows.clips.size()));
  }
  SINEW_ASSIGN_OR_RETURN(const std::vector<std::vector<int64_t>> divided,
                         Divide(rows));
  std::vector<absl::Status> answers(teachers_.size());
  const auto ask = [&](size_t t) {
    answers[t] = Ask(*teachers_[t].annotator, rows, divided[t], targets);
    return answers[t].ok();
  };
  {
    std::vector<std::jthread> threads;
    for (size_t t = 0; t < teachers_.size(); ++t) {
      if (divided[t].empty() || !teachers_[t].elsewhere) continue;
      threads.emplace_back([&ask, t] { ask(t); });
    }
    for (size_t t = 0; t < teachers_.size(); ++t) {
      if (divided[t].empty() || teachers_[t].elsewhere) continue;
      if (!ask(t)) break;
    }
  }
  for (const absl::Status& answer : answers) SINEW_RETURN_IF_ERROR(answer);
  return absl::OkStatus();
}

absl::StatusOr<std::vector<std::vector<int64_t>>> ClipAnnotator::Divide(
    const Rows& rows) const {
  std::vector<std::vector<int64_t>> divided(teachers_.size());
  const auto clips = static_cast<int64_t>(teacher_of_clip_.size());
  for (size_t row = 0; row < rows.clips.size(); ++row) {
    const int64_t clip = rows.clips[row];
    const int teacher =
        clip >= 0 && clip < clips ? teacher_of_clip_[clip] : kNone;
    if (teacher == kNone) {
      return absl::InvalidArgumentError(absl::StrCat(
          "row ", row,
          ": expected a clip that one of the teachers labels, found clip ",
          clip));
    }
    divided[teacher].push_back(static_cast<int64_t>(row));
  }
  return divided;
}

absl::Status ClipAnnotator::Ask(Annotator& teacher, const Rows& rows,
                                absl::Span<const int64_t> of_teacher,
                                absl::Span<double> targets) const {
  const int64_t action = description_.action_width();
  std::vector<float> observations;
  std::vector<double> bases;
  AppendRows(rows.observations, description_.observation_width(), of_teacher,
             observations);
  AppendRows(rows.bases, action, of_teacher, bases);
  std::vector<double> answers(bases.size());
  const absl::Status asked = teacher.Annotate(
      {.observations = observations, .bases = bases, .known_finite = true},
      absl::MakeSpan(answers));
  SINEW_RETURN_IF_ERROR(WithContext(
      asked, absl::StrCat("of the ", of_teacher.size(), " rows of its clips")));
  for (size_t i = 0; i < of_teacher.size(); ++i) {
    std::copy_n(answers.begin() + static_cast<int64_t>(i) * action, action,
                targets.begin() + of_teacher[i] * action);
  }
  return absl::OkStatus();
}

}  // namespace sinew::teacher
