#ifndef SINEW_TOOLS_REPORT_FILM_H_
#define SINEW_TOOLS_REPORT_FILM_H_

#include "absl/status/statusor.h"
#include "common/stop.h"
#include "tools/evaluation/subject.h"
#include "tools/report/run_record.h"

namespace sinew::report {

struct FilmOptions {
  double seconds = 4;  // of the clip
  double pictures_per_second = 10;
  int width = 300, height = 330;  // pixels of one body's picture
  int strip_columns = 8;
};

// Reference and simulation of a clip side by side, for a page that plays them:
//
//   {"clip", "survived", "seconds", "fps",
//    "frames", "columns", "width", "height",   of one moment in the sheet
//    "sheet": "data:image/jpeg;base64,...",    all moments, row by row
//    "strip": "data:image/jpeg;base64,..."}    film strip, two rows
//
// Blocking: computes, ~0.1 s per picture of a body. Errors: UNAVAILABLE
// without OpenGL, and those of RecordClip.
absl::StatusOr<Json> MakeFilm(const evaluation::Subject& subject, int clip,
                              const FilmOptions& options,
                              const StopToken& stop);

}  // namespace sinew::report

#endif  // SINEW_TOOLS_REPORT_FILM_H_
