#include "deploy/bundle/testing/toy_folder.h"

#include <filesystem>

#include "common/files.h"
#include "common/testing/matchers.h"
#include "common/testing/test_files.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::bundle::testing {

using ::sinew::testing::IsOk;

const world::testing::ToyWorld& Toy() {
  static const auto* toy =
      new world::testing::ToyWorld(world::testing::MakeToyWorld());
  return *toy;
}

std::string WriteToy(const std::string& name) {
  const std::string directory = sinew::testing::TestPath(name);
  EXPECT_THAT(RemoveRecursively(directory), IsOk());
  EXPECT_THAT(WriteBundle(ToyContent(Toy()), directory), IsOk());
  return directory;
}

std::vector<std::string> FilesOf(const std::string& directory) {
  std::vector<std::string> files;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(directory)) {
    if (!entry.is_regular_file()) continue;
    files.push_back(entry.path().lexically_relative(directory).string());
  }
  return files;
}

}  // namespace sinew::bundle::testing
