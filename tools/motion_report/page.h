#ifndef SINEW_TOOLS_MOTION_REPORT_PAGE_H_
#define SINEW_TOOLS_MOTION_REPORT_PAGE_H_

#include <string>
#include <vector>

#include "nlohmann/json.hpp"
#include "tools/motion_report/trajectory.h"

namespace sinew::motion_report {

// The page (page/report.html with style and the bundled script) around the
// data: one file that loads nothing. `report` is report.json with, besides,
// "library", "build", "note", "bodies" (body_shapes.h) and per clip "strip",
// "note" and "trajectory", an index into `trajectories`. Data enter as JSON in
// which no character means anything to HTML; the script puts text into the page
// as text only. Pure.
std::string MakePage(const nlohmann::json& report,
                     const std::vector<Trajectory>& trajectories);

}  // namespace sinew::motion_report

#endif  // SINEW_TOOLS_MOTION_REPORT_PAGE_H_
