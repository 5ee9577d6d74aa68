#include "sim/import/formats/testing/recordings.h"

#include <cstdlib>

#include "absl/strings/match.h"
#include "common/check.h"
#include "common/files.h"

namespace sinew::import::testing {

std::vector<std::pair<std::string, std::string>> Recordings(
    const std::string& place, const std::string& extension) {
  std::vector<std::pair<std::string, std::string>> recordings;
  const char* data = std::getenv("SINEW_DATA");
  if (data == nullptr) return recordings;
  const std::string folder = JoinPath(data, place);
  const auto names = ListDirectory(folder);
  SINEW_CHECK(names.ok()) << names.status();
  for (const std::string& name : *names) {
    if (!absl::EndsWith(name, extension)) continue;
    auto bytes = ReadFile(JoinPath(folder, name));
    SINEW_CHECK(bytes.ok()) << bytes.status();
    recordings.emplace_back(name, *std::move(bytes));
  }
  SINEW_CHECK(!recordings.empty()) << folder << ": no " << extension;
  return recordings;
}

}  // namespace sinew::import::testing
