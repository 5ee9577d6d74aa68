#include "tools/zoo/zoo_entry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::zoo {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr auto kUnfit = absl::StatusCode::kFailedPrecondition;

// A folder as zoo/ has them, whose card says what is asked for.
class ZooEntry : public ::testing::Test {
 protected:
  ZooEntry() : toy_(world::testing::MakeToyWorld()) {
    folder_ = JoinPath(toy_.folder, "entry");
    Write(bundle::testing::ToyContent(toy_));
  }

  void Write(const bundle::BundleContent& content) {
    EXPECT_THAT(MakeDirectories(folder_), IsOk());
    EXPECT_THAT(bundle::WriteBundle(content, JoinPath(folder_, "bundle")),
                IsOk());
    const auto bundle = bundle::ReadBundle(JoinPath(folder_, "bundle"));
    ASSERT_THAT(bundle, IsOk());
    manifest_ = bundle->manifest;
  }
  void WriteCard(const std::string& text) const {
    EXPECT_THAT(WriteFileAtomically(JoinPath(folder_, "CARD.md"), text),
                IsOk());
  }
  std::string Licences() const {
    std::string text;
    for (const std::string& licence : manifest_.provenance().data_licences()) {
      absl::StrAppend(&text, "- ", licence, "\n");
    }
    return text;
  }

  const world::testing::ToyWorld toy_;
  std::string folder_;
  v1::BundleManifest manifest_;
};

TEST_F(ZooEntry, IsABundleAndACardThatNamesItAndItsLicences) {
  WriteCard(absl::StrCat(manifest_.manifest_sha256(), "\n", Licences()));

  EXPECT_THAT(CheckZooEntry(folder_), IsOk());
}

TEST_F(ZooEntry, NeedsACardOfThisBundle) {
  EXPECT_THAT(CheckZooEntry(folder_),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("CARD.md")));
  WriteCard(Licences());
  EXPECT_THAT(CheckZooEntry(folder_),
              StatusIs(kUnfit, AllOf(HasSubstr("CARD.md"),
                                     HasSubstr(manifest_.manifest_sha256()))));
}

TEST_F(ZooEntry, NeedsEveryLicence) {
  WriteCard(manifest_.manifest_sha256());
  EXPECT_THAT(CheckZooEntry(folder_),
              StatusIs(kUnfit, HasSubstr("expected the licence")));

  bundle::BundleContent content = bundle::testing::ToyContent(toy_);
  content.manifest.mutable_provenance()->add_data_licences("unknown");
  Write(content);
  WriteCard(absl::StrCat(manifest_.manifest_sha256(), "\n", Licences()));
  EXPECT_THAT(CheckZooEntry(folder_),
              StatusIs(kUnfit, HasSubstr("found one that is unknown")));
}

TEST_F(ZooEntry, HasFiguresOfThisBundleWithoutPathsOfAMachine) {
  const std::string digest = manifest_.manifest_sha256();
  WriteCard(absl::StrCat(digest, "\n", Licences()));
  const auto figures = [&](absl::string_view of, absl::string_view library) {
    return absl::StrCat(R"({"bundle": {"path": "bundle", "manifest_sha256": ")",
                        of, R"("}, "library": {"path": ")", library, R"("}})");
  };

  for (const char* name : {"eval.json", "fallen.json"}) {
    const std::string file = JoinPath(folder_, name);
    ASSERT_THAT(WriteFileAtomically(file, figures(digest, "library")), IsOk());
    EXPECT_THAT(CheckZooEntry(folder_), IsOk());

    for (const std::string& other :
         {figures("ab", "library"), std::string("{")}) {
      ASSERT_THAT(WriteFileAtomically(file, other), IsOk());
      EXPECT_THAT(CheckZooEntry(folder_),
                  StatusIs(kUnfit, AllOf(HasSubstr(name),
                                         HasSubstr("bundle.manifest_sha256"),
                                         HasSubstr(digest))));
    }
    ASSERT_THAT(WriteFileAtomically(file, figures(digest, "/home/library")),
                IsOk());
    EXPECT_THAT(
        CheckZooEntry(folder_),
        StatusIs(kUnfit, AllOf(HasSubstr(name), HasSubstr("library.path"),
                               HasSubstr("found /home/library"))));
    ASSERT_THAT(WriteFileAtomically(file, figures(digest, "library")), IsOk());
  }
}

TEST_F(ZooEntry, IsNotLargerThanABundleMayBe) {
  const std::string bundle = JoinPath(folder_, "bundle");
  const auto bytes = CheckBundleBytes(bundle);
  ASSERT_THAT(bytes, IsOk());
  EXPECT_GT(*bytes, 0);
  const std::string filler(kMostBundleBytes - *bytes + 1, 'x');
  ASSERT_THAT(WriteFileAtomically(JoinPath(bundle, "filler"), filler), IsOk());

  EXPECT_THAT(CheckBundleBytes(bundle),
              StatusIs(kUnfit, AllOf(HasSubstr("at most 8000000 bytes"),
                                     HasSubstr("found 8000001"))));
  EXPECT_THAT(FolderBytes(JoinPath(folder_, "nowhere")),
              StatusIs(absl::StatusCode::kNotFound));
}

}  // namespace
}  // namespace sinew::zoo
