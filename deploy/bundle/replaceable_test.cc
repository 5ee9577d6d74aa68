#include "deploy/bundle/replaceable.h"

#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "common/testing/test_files.h"
#include "deploy/bundle/manifest.h"
#include "deploy/bundle/testing/toy_folder.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::bundle {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::sinew::testing::TestPath;
using ::testing::HasSubstr;
using testing::WriteToy;

std::string Folder(const std::string& name, const std::string& file,
                   const std::string& content) {
  const std::string folder = TestPath(name);
  EXPECT_THAT(MakeDirectories(folder), IsOk());
  EXPECT_THAT(WriteFileAtomically(JoinPath(folder, file), content), IsOk());
  return folder;
}

auto IsForeign(const std::string& folder, const std::string& found) {
  return StatusIs(absl::StatusCode::kFailedPrecondition,
                  HasSubstr(absl::StrCat(
                      folder, ": expected a bundle, an empty folder or none, ",
                      "found one that holds ", found)));
}

TEST(CheckReplaceable, TakesABundleAnEmptyFolderAndNone) {
  ASSERT_THAT(MakeDirectories(TestPath("empty")), IsOk());

  EXPECT_THAT(CheckReplaceable(WriteToy()), IsOk());
  EXPECT_THAT(CheckReplaceable(TestPath("empty") + "/"), IsOk());
  EXPECT_THAT(CheckReplaceable(TestPath("none")), IsOk());
}

TEST(CheckReplaceable, NamesWhatIsNoPartOfABundle) {
  const std::string bundle = WriteToy();
  ASSERT_THAT(WriteFileAtomically(JoinPath(bundle, "notes.txt"), "mine"),
              IsOk());

  EXPECT_THAT(CheckReplaceable(bundle), IsForeign(bundle, "notes.txt"));
}

TEST(CheckReplaceable, WantsTheManifestOfABundle) {
  const std::string models = Folder("models", "mine.onnx", "weights");
  EXPECT_THAT(CheckReplaceable(models),
              IsForeign(models, "no manifest.json of a bundle but mine.onnx"));
  const std::string page = Folder("page", kManifestFile, "{\"icons\": []}");
  EXPECT_THAT(CheckReplaceable(page),
              IsForeign(page, "no manifest.json of a bundle"));
}

TEST(CheckReplaceable, LooksAtTheFoldersThatAreWorkedIn) {
  const std::string part = Folder("one.part", "thesis.txt", "years");
  EXPECT_THAT(CheckReplaceable(TestPath("one")), IsForeign(part, "thesis.txt"));
  // What a killed writer left.
  Folder("two.part", kWeightsFile, "half");
  EXPECT_THAT(CheckReplaceable(TestPath("two")), IsOk());
  const std::string old = Folder("three.old", "thesis.txt", "years");
  EXPECT_THAT(CheckReplaceable(TestPath("three")),
              IsForeign(old, "thesis.txt"));
}

}  // namespace
}  // namespace sinew::bundle
