#include "sim/import/credit.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <system_error>

namespace sinew::import {
namespace {

std::filesystem::path Normal(const std::string& path) {
  std::error_code error;  // without a working folder: as it is
  std::filesystem::path normal = std::filesystem::absolute(path, error);
  if (error) normal = path;
  normal = normal.lexically_normal();
  // "folder/" is "folder".
  return normal.has_filename() ? normal : normal.parent_path();
}

int Depth(const std::string& path) {
  const std::filesystem::path normal = Normal(path);
  return static_cast<int>(std::distance(normal.begin(), normal.end()));
}

std::string JoinedText(const std::string& first, const std::string& second) {
  if (second == first) return first;
  const std::string unknown = "unknown";
  return (first.empty() ? unknown : first) + "; " +
         (second.empty() ? unknown : second);
}

}  // namespace

bool LiesWithin(const std::string& file, const std::string& path) {
  if (file.empty() || path.empty()) return false;
  const std::filesystem::path inner = Normal(file), outer = Normal(path);
  return std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end())
             .first == outer.end();
}

const PathCredit* NearestCredit(const std::string& file,
                                const std::vector<PathCredit>& credits) {
  const PathCredit* nearest = nullptr;
  for (const PathCredit& candidate : credits) {
    if (!LiesWithin(file, candidate.path)) continue;
    if (nearest == nullptr || Depth(candidate.path) >= Depth(nearest->path)) {
      nearest = &candidate;
    }
  }
  return nearest;
}

Credit CreditOf(const std::string& file, const std::vector<PathCredit>& credits,
                const Credit& otherwise) {
  const PathCredit* nearest = NearestCredit(file, credits);
  return nearest == nullptr ? otherwise : nearest->credit;
}

Credit Joined(const Credit& first, const Credit& second) {
  return {JoinedText(first.provenance, second.provenance),
          JoinedText(first.licence, second.licence)};
}

}  // namespace sinew::import
