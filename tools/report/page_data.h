#ifndef SINEW_TOOLS_REPORT_PAGE_DATA_H_
#define SINEW_TOOLS_REPORT_PAGE_DATA_H_

#include <string>

#include "proto/sinew/v1/motion.pb.h"
#include "tools/report/run_record.h"

namespace sinew::report {

// What the run directory does not say.
struct PageContext {
  std::string motions;        // library folder; empty: unknown
  v1::MotionLibrary library;  // its manifest; no clips: unknown
  Json film;                  // film.h; null: no pictures, `film_note` why
  std::string film_note;
  // CurriculumJson of tools/curriculum; null: there is no training state.
  Json curriculum;
  std::string build;  // of the program that writes the report
};

// Everything that the page (page/report.js) shows, as one JSON object:
//
//   title, run, notes[], build
//   headline   starts, succeeded_starts, survived_share, e_g_mpjpe_mm, ...,
//              seconds, clips, source ("eval.json" or "training"),
//              zero_action {same}; minutes, wall_minutes, samples, iterations
//   training, evaluations   curves.h
//   curriculum              curves (curves.h), and what `context` has of it;
//                           null where all episodes start in one bin
//   core_seconds            cores, wall, total, stages[{name, what, seconds}]
//   lag        counts {lag: iterations}, reissued
//   evaluation eval.json as it is; film, film_note; config (text)
//   reproduce  reproduce.h; credits [{name, origin, licence}]
//
// Absent things are null or missing. Pure.
Json MakePageData(const RunRecord& run, const PageContext& context);

}  // namespace sinew::report

#endif  // SINEW_TOOLS_REPORT_PAGE_DATA_H_
