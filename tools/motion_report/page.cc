#include "tools/motion_report/page.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "tools/motion_report/page_files.h"
#include "tools/report/inert_json.h"

namespace sinew::motion_report {
namespace {

// Each in an element of its own, unpacked when it is played.
std::string Elements(const std::vector<Trajectory>& trajectories) {
  std::string elements;
  for (size_t i = 0; i < trajectories.size(); ++i) {
    const Trajectory& shown = trajectories[i];
    const nlohmann::json json = {{"fps", shown.frames_per_second},
                                 {"frames", shown.frames},
                                 {"bodies", shown.bodies},
                                 {"cut", shown.cut},
                                 {"body_position", shown.body_position},
                                 {"body_rotation", shown.body_rotation},
                                 {"source_parents", shown.source_parents},
                                 {"source_position", shown.source_position}};
    absl::StrAppend(&elements,
                    "<script type=\"application/json\" id=\"trajectory-", i,
                    "\">", report::InertJson(json), "</script>\n");
  }
  return elements;
}

}  // namespace

std::string MakePage(const nlohmann::json& report,
                     const std::vector<Trajectory>& trajectories) {
  // One pass: what is put in is not searched again.
  return absl::StrReplaceAll(kReportHtml,
                             {{"/*report.css*/", kReportCss},
                              {"/*report.js*/", kReportJs},
                              {"/*data*/", report::InertJson(report)},
                              {"<!--trajectories-->", Elements(trajectories)}});
}

}  // namespace sinew::motion_report
