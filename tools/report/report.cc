#include "tools/report/report.h"

#include "absl/strings/str_cat.h"
#include "common/build_info.h"
#include "common/clock.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "sim/motion/library.h"
#include "tools/curriculum/run_curriculum.h"
#include "tools/evaluation/bundle_subject.h"
#include "tools/evaluation/subject.h"
#include "tools/report/curves.h"
#include "tools/report/film.h"
#include "tools/report/page.h"
#include "tools/report/page_data.h"
#include "tools/report/run_record.h"

namespace sinew::report {
namespace {

// Clips that the page lists as the hardest.
constexpr int kHardestClips = 20;

// The film of the bundle's policy. CANCELLED and a clip that is not there are
// the caller's; any other failure becomes a note in the page.
absl::Status AddFilm(const ReportOptions& options, const StopToken& stop,
                     const std::string& bundle, PageContext* context) {
  auto subject = evaluation::LoadBundleSubject(bundle, context->motions);
  if (!subject.ok()) {
    context->film_note = std::string(subject.status().message());
    return absl::OkStatus();
  }
  SINEW_ASSIGN_OR_RETURN(
      const int clip,
      evaluation::FindClip(subject->subject.library(), options.clip));
  auto film = MakeFilm(subject->subject, clip, FilmOptions(), stop);
  if (film.ok()) {
    context->film = *std::move(film);
  } else if (absl::IsCancelled(film.status())) {
    return film.status();
  } else {
    context->film_note = std::string(film.status().message());
  }
  return absl::OkStatus();
}

// The curriculum of the newest training state; null: it cannot be read. Why
// becomes a note, where the run has a curriculum to show.
Json CurriculumOf(const std::string& path, RunRecord& run) {
  const SystemClock clock;
  const auto curriculum = tools::ReadRunCurriculum(path, clock);
  if (curriculum.ok()) return tools::CurriculumJson(*curriculum, kHardestClips);
  if (!CurriculumCurves(run.rows).empty()) {
    run.notes.push_back(absl::StrCat("The curriculum cannot be read: ",
                                     curriculum.status().message()));
  }
  return nullptr;
}

}  // namespace

absl::StatusOr<std::string> WriteReport(const ReportOptions& options,
                                        const StopToken& stop) {
  SINEW_ASSIGN_OR_RETURN(RunRecord run, ReadRun(options.run));
  PageContext context;
  context.build = BuildIdentity();
  context.curriculum = CurriculumOf(options.run, run);
  context.motions =
      options.motions.empty() ? run.evaluated_motions : options.motions;
  if (context.motions.empty()) {
    context.film_note = "No motion library was named.";
  } else if (auto library = motion::Library::Load(context.motions);
             !library.ok()) {
    context.film_note = std::string(library.status().message());
  } else {
    context.library = (*library)->manifest();
    if (run.manifest.is_object()) {
      SINEW_RETURN_IF_ERROR(AddFilm(options, stop, run.bundle, &context));
    } else {
      context.film_note = "The run has no bundle.";
    }
  }
  const std::string out =
      options.out.empty() ? JoinPath(options.run, "report.html") : options.out;
  SINEW_RETURN_IF_ERROR(
      WriteFileAtomically(out, MakePage(MakePageData(run, context))));
  return out;
}

}  // namespace sinew::report
