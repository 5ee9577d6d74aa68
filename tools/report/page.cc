#include "tools/report/page.h"

#include "absl/strings/str_replace.h"
#include "tools/report/page_files.h"

namespace sinew::report {
namespace {

// JSON that may stand inside <script>: the same values, but for characters
// that HTML or old JavaScript would see.
std::string InertJson(const Json& data) {
  const std::string text = data.dump(-1, ' ', /*ensure_ascii=*/true,
                                     Json::error_handler_t::replace);
  return absl::StrReplaceAll(
      text, {{"<", "\\u003c"}, {">", "\\u003e"}, {"&", "\\u0026"}});
}

}  // namespace

std::string MakePage(const Json& data) {
  // One pass: what is put in is not searched again.
  return absl::StrReplaceAll(kReportHtml, {{"/*report.css*/", kReportCss},
                                           {"/*charts.js*/", kChartsJs},
                                           {"/*report.js*/", kReportJs},
                                           {"/*data*/", InertJson(data)}});
}

}  // namespace sinew::report
