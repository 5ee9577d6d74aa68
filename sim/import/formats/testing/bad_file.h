#ifndef SINEW_SIM_IMPORT_FORMATS_TESTING_BAD_FILE_H_
#define SINEW_SIM_IMPORT_FORMATS_TESTING_BAD_FILE_H_

#include <string>

#include "absl/status/status.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"

namespace sinew::import::testing {

// A file that a reader must refuse, and what its error must say.
struct BadFile {
  std::string text;
  std::string expected;
};

// Matches INVALID_ARGUMENT with both texts in its message: the start, that
// names the file ("dir/clip.bvh: "), and what was expected and found.
inline auto IsRefused(const std::string& start, const std::string& expected) {
  return ::sinew::testing::StatusIs(
      absl::StatusCode::kInvalidArgument,
      ::testing::AllOf(::testing::HasSubstr(start),
                       ::testing::HasSubstr(expected)));
}

}  // namespace sinew::import::testing

#endif  // SINEW_SIM_IMPORT_FORMATS_TESTING_BAD_FILE_H_
