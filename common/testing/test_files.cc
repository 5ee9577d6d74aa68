#include "common/testing/test_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/files.h"
#include "common/testing/matchers.h"

namespace sinew::testing {

std::string TestPath(const std::string& name) {
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  return JoinPath(
      JoinPath(JoinPath(::testing::TempDir(), test->test_suite_name()),
               test->name()),
      name);
}

std::string WriteTestFile(const std::string& name, absl::string_view content) {
  const std::string path = TestPath(name);
  EXPECT_THAT(MakeDirectories(path.substr(0, path.find_last_of('/'))), IsOk());
  EXPECT_THAT(WriteFileAtomically(path, content), IsOk());
  return path;
}

}  // namespace sinew::testing
