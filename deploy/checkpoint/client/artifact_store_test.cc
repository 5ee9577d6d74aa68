#include "deploy/checkpoint/client/artifact_store.h"

#include <memory>
#include <string>

#include "common/testing/matchers.h"
#include "deploy/checkpoint/client/testing/memory_store.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "proto/sinew/v1/checkpoint.pb.h"

namespace sinew::checkpoint {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;

// A store that is not to be trusted: it calls the one file of every artifact
// `path`.
class RenamingStore : public MemoryStore {
 public:
  explicit RenamingStore(const std::string& path) : path_(path) {}

  absl::StatusOr<v1::Artifact> GetArtifact(const std::string& name) override {
    absl::StatusOr<v1::Artifact> artifact = MemoryStore::GetArtifact(name);
    if (artifact.ok()) artifact->mutable_files(0)->set_path(path_);
    return artifact;
  }

 private:
  const std::string path_;
};

absl::Status PutOne(ArtifactStore& store) {
  v1::Artifact record;
  record.set_id("bundle-1");
  record.set_kind("bundle");
  return PutFiles(store, record,
                  {{"file", std::make_shared<const std::string>("bytes")}});
}

TEST(GetFiles, RefusesPathsThatWouldLeaveTheFolder) {
  for (const std::string path :
       {"../x", "/etc/x", "a/../../x", "a//x", "", ".", "a\\x"}) {
    RenamingStore store(path);
    ASSERT_THAT(PutOne(store), IsOk());

    EXPECT_THAT(GetFiles(store, "bundle-1"),
                StatusIs(absl::StatusCode::kDataLoss,
                         AllOf(HasSubstr("artifact bundle-1: path: expected"),
                               HasSubstr("found \""))))
        << path;
  }
}

TEST(GetFiles, TakesPathsBelowTheFolder) {
  RenamingStore store("a/x");
  ASSERT_THAT(PutOne(store), IsOk());

  EXPECT_THAT(GetFiles(store, "bundle-1"), IsOk());
}

}  // namespace
}  // namespace sinew::checkpoint
