#ifndef SINEW_SIM_IMPORT_FORMATS_TESTING_RECORDINGS_H_
#define SINEW_SIM_IMPORT_FORMATS_TESTING_RECORDINGS_H_

#include <string>
#include <utility>
#include <vector>

namespace sinew::import::testing {

// Names and bytes of the files with an extension (".csv") in a folder of
// recordings: `place` below the folder that the environment's SINEW_DATA names.
// Sorted by name; empty only where SINEW_DATA is unset. Aborts, naming the
// path, where it is set and the folder or a file cannot be read, or where there
// is no such file.
std::vector<std::pair<std::string, std::string>> Recordings(
    const std::string& place, const std::string& extension);

}  // namespace sinew::import::testing

#endif  // SINEW_SIM_IMPORT_FORMATS_TESTING_RECORDINGS_H_
