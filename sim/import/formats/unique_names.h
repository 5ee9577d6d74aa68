#ifndef SINEW_SIM_IMPORT_FORMATS_UNIQUE_NAMES_H_
#define SINEW_SIM_IMPORT_FORMATS_UNIQUE_NAMES_H_

#include <set>
#include <string>

#include "absl/strings/str_cat.h"

namespace sinew::import {

// Names of joints that are to be different: of "Hand", "Hand" the second
// becomes "Hand_2".
//
// Thread-safety: none. Ownership: its own copies. Blocking: never. Errors:
// none.
class UniqueNames {
 public:
  // `name`, or with the least number that makes it new.
  std::string Take(const std::string& name) {
    std::string unique = name;
    for (int i = 2; !taken_.insert(unique).second; ++i) {
      unique = absl::StrCat(name, "_", i);
    }
    return unique;
  }

 private:
  std::set<std::string> taken_;
};

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_UNIQUE_NAMES_H_
