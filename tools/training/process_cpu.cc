#include "tools/training/process_cpu.h"

#include <unistd.h>

#include <string>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "common/files.h"

namespace sinew::tools {
namespace {

// Fields of /proc/PID/stat after the program's name, which ends with ')'.
constexpr size_t kUserTicks = 11;
constexpr size_t kSystemTicks = 12;

}  // namespace

double ProcessCpuSeconds(pid_t pid) {
  const auto text =
      ReadFile(absl::StrCat("/proc/", pid, "/stat"), /*max_bytes=*/1 << 14);
  if (!text.ok()) return 0;
  const size_t name_end = text->rfind(") ");
  if (name_end == std::string::npos) return 0;
  const std::vector<std::string> fields =
      absl::StrSplit(text->substr(name_end + 2), ' ');
  double user = 0;
  double system = 0;
  if (fields.size() <= kSystemTicks ||
      !absl::SimpleAtod(fields[kUserTicks], &user) ||
      !absl::SimpleAtod(fields[kSystemTicks], &system)) {
    return 0;
  }
  return (user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
}

}  // namespace sinew::tools
