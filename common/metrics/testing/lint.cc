#include "common/metrics/testing/lint.h"

#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>

#include "absl/strings/str_cat.h"
#include "common/files.h"
#include "common/status_macros.h"

namespace sinew::metrics {
namespace {

constexpr char kPromtool[] = "/usr/bin/promtool";

}  // namespace

absl::Status Lint(const std::string& text) {
  if (!FileExists(kPromtool)) {
    return absl::FailedPreconditionError(
        absl::StrCat(kPromtool, " is missing: apt-get install prometheus"));
  }
  const char* folder = std::getenv("TEST_TMPDIR");
  const std::string path = JoinPath(folder != nullptr ? folder : "/tmp",
                                    absl::StrCat("scrape-", getpid()));
  SINEW_RETURN_IF_ERROR(WriteFileAtomically(path, text));
  std::FILE* pipe = popen(
      absl::StrCat(kPromtool, " check metrics < ", path, " 2>&1").c_str(), "r");
  if (pipe == nullptr) return absl::InternalError("popen failed");
  std::string output;
  std::array<char, 4096> buffer;
  while (std::fgets(buffer.data(), buffer.size(), pipe) != nullptr) {
    output += buffer.data();
  }
  const int status = pclose(pipe);
  std::remove(path.c_str());
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat("promtool check metrics: ", output));
}

}  // namespace sinew::metrics
