#ifndef SINEW_TOOLS_REPORT_PAGE_H_
#define SINEW_TOOLS_REPORT_PAGE_H_

#include <string>

#include "tools/report/run_record.h"

namespace sinew::report {

// The page (page/report.html with its style and scripts) around the data:
// one file that loads nothing. Data enter as JSON in which no character means
// anything to HTML, and the scripts put text into the page as text only, so
// whatever names and paths hold is shown, never run. Pure.
std::string MakePage(const Json& data);

}  // namespace sinew::report

#endif  // SINEW_TOOLS_REPORT_PAGE_H_
