#ifndef SINEW_TOOLS_REPORT_TESTING_BROWSER_H_
#define SINEW_TOOLS_REPORT_TESTING_BROWSER_H_

#include <string>
#include <vector>

namespace sinew::report::testing {

// Opens a page in headless Chromium with further flags, e.g. "--dump-dom", and
// returns what the browser writes to its standard output. Its profile and log
// go into `folder`. Needs the Debian package chromium-headless-shell. Blocking:
// seconds, three minutes at most. Failures end the program.
std::string Browse(const std::string& page, const std::string& folder,
                   const std::vector<std::string>& flags);

}  // namespace sinew::report::testing

#endif  // SINEW_TOOLS_REPORT_TESTING_BROWSER_H_
