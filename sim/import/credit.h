#ifndef SINEW_SIM_IMPORT_CREDIT_H_
#define SINEW_SIM_IMPORT_CREDIT_H_

#include <string>
#include <vector>

namespace sinew::import {

// Origin and licence of a file's data; copied into the library, from where
// bundles and model cards name them.
struct Credit {
  std::string provenance = {};
  std::string licence = {};

  friend bool operator==(const Credit&, const Credit&) = default;
};

// The credit of a file, or of all files below a folder.
struct PathCredit {
  std::string path;
  Credit credit = {};
};

// Whether `file` is `path` or lies below it. Paths are compared as text, made
// absolute and without "." and "..": links are not followed. Within an empty
// path lies nothing. Pure but for the working folder.
bool LiesWithin(const std::string& file, const std::string& path);

// The one of `credits` whose path is nearest to the file, of equal ones the
// last; null: it lies within none.
const PathCredit* NearestCredit(const std::string& file,
                                const std::vector<PathCredit>& credits);

// Its credit, or `otherwise`.
Credit CreditOf(const std::string& file, const std::vector<PathCredit>& credits,
                const Credit& otherwise);

// Of a clip that is made of two files: each thing once, and "unknown" for what
// one of them does not say.
Credit Joined(const Credit& first, const Credit& second);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_CREDIT_H_
