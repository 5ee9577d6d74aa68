#include <algorithm>

#include "absl/status/statusor.h"
#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/string_view.h"
#include "common/files.h"
#include "sim/import/formats/asf_amc.h"

namespace sinew::import {
namespace {

constexpr absl::string_view kExtension = ".asf";

// "02_01" of "02_01.amc".
absl::string_view Stem(absl::string_view name) {
  return name.substr(0, name.rfind('.'));
}

// Whether "charleston" is the start of "charleston1". "1" is none of "13_2":
// numbers are not cut.
bool Begins(absl::string_view stem, absl::string_view own) {
  if (own.empty() || !absl::StartsWith(stem, own)) return false;
  return stem.size() == own.size() || !absl::ascii_isdigit(own.back()) ||
         !absl::ascii_isdigit(stem[own.size()]);
}

}  // namespace

std::vector<std::string> AsfCandidates(const std::string& amc_path) {
  const size_t slash = amc_path.rfind('/');
  const std::string folder =
      slash == std::string::npos ? "" : amc_path.substr(0, slash + 1);
  const absl::string_view stem = Stem(absl::string_view(amc_path).substr(
      slash == std::string::npos ? 0 : slash + 1));
  const absl::string_view subject = stem.substr(0, stem.find('_'));
  absl::StatusOr<std::vector<std::string>> names =
      ListDirectory(folder.empty() ? "." : folder);
  if (!names.ok()) return {};
  std::erase_if(*names, [](const std::string& name) {
    return !absl::EndsWithIgnoreCase(name, kExtension);
  });
  const bool is_single = names->size() == 1;
  const auto rank = [&](const std::string& name) {
    const absl::string_view own = Stem(name);
    if (own == stem) return 0;
    if (own == subject) return 1;
    if (Begins(stem, own)) return 2;
    return is_single ? 3 : 4;
  };
  std::erase_if(*names,
                [&rank](const std::string& name) { return rank(name) == 4; });
  std::sort(names->begin(), names->end(),
            [&rank](const std::string& a, const std::string& b) {
              if (rank(a) != rank(b)) return rank(a) < rank(b);
              return a.size() != b.size() ? a.size() > b.size() : a < b;
            });
  for (std::string& name : *names) name.insert(0, folder);
  return *std::move(names);
}

}  // namespace sinew::import
