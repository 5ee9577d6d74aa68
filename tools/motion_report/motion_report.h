#ifndef SINEW_TOOLS_MOTION_REPORT_MOTION_REPORT_H_
#define SINEW_TOOLS_MOTION_REPORT_MOTION_REPORT_H_

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/stop.h"
#include "sim/character/character.h"

namespace sinew::motion_report {

struct MotionReportOptions {
  // At most so many clips get a strip of pictures, rejected and warned ones
  // first; drawing without a GPU takes half a second each.
  int pictures = std::numeric_limits<int>::max();
  // Trajectories for the viewer take at most so much of the page, in the same
  // order; further clips say how to see them.
  double trajectory_megabytes = 60;
  // Of these clips alone; empty: of all.
  std::vector<std::string> clips = {};
  // Called after each picture strip with how many of how many are drawn.
  std::function<void(int, int)> on_picture = {};
};

// Writes LIB/report.html from LIB/report.json and the cache that
// import::ImportFiles left there: one file that loads nothing, with a sortable
// table of all clips and their figures, pictures, and a viewer (WebGL) that
// plays source skeleton and character side by side. Returns its path. What is
// missing (the cache, OpenGL) the page says.
//
//   import::ImportFiles -> LIB/report.json, LIB/cache -> WriteMotionReport
//
// Thread-safety: uses OpenGL; one call at a time. Blocking: reads every clip
// that it shows; pictures. Errors: NOT_FOUND (no report.json, no such clip),
// INVALID_ARGUMENT (it is none of ours), CANCELLED, those of writing.
absl::StatusOr<std::string> WriteMotionReport(
    const character::Character& character, const std::string& library,
    const MotionReportOptions& options, const StopToken& stop);

// Name of the character that LIB/report.json is about. Blocking: on the disk.
// Errors: NOT_FOUND, INVALID_ARGUMENT as above.
absl::StatusOr<std::string> ReportedCharacter(const std::string& library);

}  // namespace sinew::motion_report

#endif  // SINEW_TOOLS_MOTION_REPORT_MOTION_REPORT_H_
