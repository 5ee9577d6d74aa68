#ifndef SINEW_COMMON_TESTING_TEST_FILES_H_
#define SINEW_COMMON_TESTING_TEST_FILES_H_

#include <string>

#include "absl/strings/string_view.h"

namespace sinew::testing {

// A path in a folder of the running test's own.
std::string TestPath(const std::string& name);

// Writes a file there, with the folders that `name` has, and returns its path.
// Fails the test if that cannot be done.
std::string WriteTestFile(const std::string& name, absl::string_view content);

}  // namespace sinew::testing

#endif  // SINEW_COMMON_TESTING_TEST_FILES_H_
