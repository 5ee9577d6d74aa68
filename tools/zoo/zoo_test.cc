// What lies in zoo/.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <system_error>

#include "common/files.h"
#include "common/testing/matchers.h"
#include "tools/zoo/zoo_entry.h"

namespace sinew::zoo {
namespace {

using ::sinew::testing::IsOk;
namespace fs = std::filesystem;

// The folder where the runfile BUILD.bazel really lies is the source tree's.
TEST(Zoo, HasAGoodBundleAndItsCardInEveryFolder) {
  std::error_code error;
  const fs::path root = fs::canonical("BUILD.bazel", error).parent_path();
  ASSERT_FALSE(error) << error.message();
  const std::string zoo = (root / "zoo").string();
  ASSERT_TRUE(FileExists(JoinPath(zoo, "README.md"))) << zoo;

  for (const fs::directory_entry& entry : fs::directory_iterator(zoo)) {
    if (!entry.is_directory()) continue;
    EXPECT_THAT(CheckZooEntry(entry.path().string()), IsOk());
  }
}

}  // namespace
}  // namespace sinew::zoo
