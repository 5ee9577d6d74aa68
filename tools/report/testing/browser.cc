#include "tools/report/testing/browser.h"

#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "common/check.h"
#include "common/files.h"
#include "common/subprocess.h"

namespace sinew::report::testing {

std::string Browse(const std::string& page, const std::string& folder,
                   const std::vector<std::string>& flags) {
  const std::string log = JoinPath(folder, "browser.log");
  SINEW_CHECK(RemoveRecursively(log).ok());
  std::vector<std::string> argv = {
      "chromium-headless-shell", "--no-sandbox", "--disable-dev-shm-usage",
      "--hide-scrollbars",
      absl::StrCat("--user-data-dir=", JoinPath(folder, "profile"))};
  argv.insert(argv.end(), flags.begin(), flags.end());
  argv.push_back(absl::StrCat("file://", page));
  auto browser = Subprocess::Start(
      {.argv = argv, .environment = {{"HOME", folder}}, .output_file = log});
  SINEW_CHECK(browser.ok()) << browser.status().ToString();
  const auto exit = (*browser)->Wait(absl::Minutes(3));
  SINEW_CHECK(exit.ok() && exit->ok()) << *ReadFile(log);
  return *ReadFile(log);
}

}  // namespace sinew::report::testing
