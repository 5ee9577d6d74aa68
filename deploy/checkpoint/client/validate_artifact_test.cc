#include "deploy/checkpoint/client/validate_artifact.h"

#include <string>
#include <vector>

#include "common/digest.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::checkpoint {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

v1::Artifact MakeArtifact(const std::vector<std::string>& paths) {
  v1::Artifact artifact;
  artifact.set_id("state-00000120");
  artifact.set_kind("state");
  for (const std::string& path : paths) {
    v1::Artifact::File& file = *artifact.add_files();
    file.set_path(path);
    file.set_sha256(Sha256Hex(path));
    file.set_size(3);
  }
  return artifact;
}

auto Refused(const std::string& text) {
  return StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr(text));
}

TEST(ValidateArtifact, TakesFilesInFolders) {
  EXPECT_THAT(ValidateArtifact(MakeArtifact(
                  {"a b.txt", "character/meshes/torso.stl", "state.pb"})),
              IsOk());
}

TEST(ValidateArtifact, RefusesPathsThatLeaveTheFolderOrNeedQuoting) {
  for (const std::string& path :
       {std::string("/a"), std::string("a/"), std::string("./a"),
        std::string("a/../../b"), std::string("a\\b"), std::string("a\nb"),
        std::string("a\0b", 3), std::string(256, 'a'),
        std::string("x.sinew-tmp-1-2")}) {
    EXPECT_THAT(ValidateArtifact(MakeArtifact({path})),
                Refused("path: expected a relative path"))
        << path;
  }
}

TEST(ValidateArtifact, RefusesFilesThatAreNotSortedOrTwiceThere) {
  EXPECT_THAT(ValidateArtifact(MakeArtifact({"b", "a"})),
              Refused("expected one after \"b\", found \"a\""));
  EXPECT_THAT(ValidateArtifact(MakeArtifact({"a", "a"})),
              Refused("expected one after \"a\""));
}

TEST(ValidateArtifact, RefusesAFileThatIsAnothersFolder) {
  EXPECT_THAT(ValidateArtifact(MakeArtifact({"a", "a.b", "a/b"})),
              Refused("expected \"a\" to be a file, found \"a/b\""));
}

TEST(ValidateArtifact, RefusesNoFilesNoDigestAndNegativeSizes) {
  EXPECT_THAT(ValidateArtifact(MakeArtifact({})), Refused("files"));
  v1::Artifact artifact = MakeArtifact({"a"});
  artifact.mutable_files(0)->set_size(-1);
  EXPECT_THAT(ValidateArtifact(artifact), Refused("size: expected >= 0"));
  artifact.mutable_files(0)->set_sha256("ABC");
  EXPECT_THAT(ValidateArtifact(artifact), Refused("digest"));
}

TEST(ValidateName, RefusesWhatIsNoFileName) {
  EXPECT_THAT(ValidateName("alias", "latest"), IsOk());
  for (const std::string& name :
       {std::string(), std::string("."), std::string(".."), std::string("a/b"),
        std::string("a b"), std::string(129, 'a'), std::string("\xc3\xa4")}) {
    EXPECT_THAT(ValidateName("alias", name), Refused("alias: expected"))
        << name;
  }
}

TEST(ValidateKind, TakesSmallLettersOnly) {
  EXPECT_THAT(ValidateKind("bundle"), IsOk());
  for (const std::string& kind : {"", "State", "a-b", "a/b"}) {
    EXPECT_THAT(ValidateKind(kind), Refused("kind")) << kind;
  }
}

}  // namespace
}  // namespace sinew::checkpoint
