#include "tools/report/page.h"

#include "absl/strings/str_replace.h"
#include "tools/report/inert_json.h"
#include "tools/report/page_files.h"

namespace sinew::report {

std::string MakePage(const Json& data) {
  // One pass: what is put in is not searched again.
  return absl::StrReplaceAll(kReportHtml, {{"/*report.css*/", kReportCss},
                                           {"/*charts.js*/", kChartsJs},
                                           {"/*report.js*/", kReportJs},
                                           {"/*data*/", InertJson(data)}});
}

}  // namespace sinew::report
