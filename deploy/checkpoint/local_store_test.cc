#include "deploy/checkpoint/local_store.h"

#include <sys/stat.h>
#include <unistd.h>

#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/clock.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "deploy/checkpoint/client/artifact_index.h"
#include "deploy/checkpoint/client/testing/store_conformance.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::checkpoint {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// A folder of the running test's own, not there yet.
std::string NewFolder() {
  static int count = 0;
  const std::string folder =
      JoinPath(::testing::TempDir(),
               absl::StrCat("local_store-", getpid(), "-", ++count));
  EXPECT_THAT(RemoveRecursively(folder), IsOk());
  return folder;
}

class InFolder : public StoreFixture {
 public:
  InFolder() : store_(*LocalStore::Open(NewFolder(), clock_)) {}
  ArtifactStore& store() override { return *store_; }

 private:
  const SystemClock clock_;
  const std::unique_ptr<LocalStore> store_;
};

INSTANTIATE_TEST_SUITE_P(Local, StoreConformance,
                         ::testing::Values(StoreMaker([] {
                           return std::make_unique<InFolder>();
                         })));

Blob MakeBlob(const std::string& bytes) {
  return std::make_shared<const std::string>(bytes);
}

absl::Status Put(ArtifactStore& store, const std::string& id) {
  v1::Artifact record;
  record.set_id(id);
  record.set_kind("state");
  return PutFiles(store, record,
                  {{"own", MakeBlob("own of " + id)},
                   {"shared", MakeBlob("shared by all")}});
}

class LocalStoreTest : public ::testing::Test {
 protected:
  std::unique_ptr<LocalStore> Open() {
    auto store = LocalStore::Open(folder_, clock_);
    EXPECT_THAT(store, IsOk());
    return *std::move(store);
  }
  std::string BlobPath(const std::string& bytes) const {
    return JoinPath(folder_, "blobs/" + Sha256Hex(bytes));
  }
  std::vector<std::string> Names(const std::string& part) const {
    return *ListDirectory(JoinPath(folder_, part));
  }

  const std::string folder_ = NewFolder();
  const SystemClock clock_;
};

TEST_F(LocalStoreTest, FindsAllOfItAgain) {
  {
    const auto store = Open();
    ASSERT_THAT(Put(*store, "s1"), IsOk());
    ASSERT_THAT(Put(*store, "s2"), IsOk());
    ASSERT_THAT(store->SetAlias("best", "s1"), IsOk());
  }

  const auto store = Open();

  EXPECT_EQ(store->GetArtifact("best")->id(), "s1");
  EXPECT_EQ(store->ListArtifacts("state")->artifacts(0).id(), "s2");
  EXPECT_THAT(GetFiles(*store, "s2"), IsOk());
  ASSERT_THAT(Put(*store, "s3"), IsOk());
  EXPECT_EQ(store->GetArtifact("s3")->sequence(), 3);
}

TEST_F(LocalStoreTest, WritesOnlyWhatIsNew) {
  const auto store = Open();
  ASSERT_THAT(Put(*store, "s1"), IsOk());
  // What was written again would have its usual permissions.
  const std::string path = BlobPath("shared by all");
  ASSERT_EQ(chmod(path.c_str(), 0400), 0);

  ASSERT_THAT(Put(*store, "s2"), IsOk());

  struct stat info;
  ASSERT_EQ(stat(path.c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777, 0400u);
  EXPECT_THAT(Names("blobs"), SizeIs(3));
}

TEST_F(LocalStoreTest, IsOpenToOneWriterAndNamesIt) {
  const auto store = Open();

  EXPECT_THAT(
      LocalStore::Open(folder_, clock_),
      StatusIs(absl::StatusCode::kFailedPrecondition,
               AllOf(HasSubstr(folder_), HasSubstr(absl::StrCat(getpid())))));
}

TEST_F(LocalStoreTest, MayBeReadBesideItsWriter) {
  const auto writer = Open();
  const auto reader = LocalStore::OpenReadOnly(folder_, clock_);
  ASSERT_THAT(reader, IsOk());

  ASSERT_THAT(Put(*writer, "s1"), IsOk());

  EXPECT_THAT(GetFiles(**reader, "s1"), IsOk());
  EXPECT_THAT(Put(**reader, "s2"),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("for reading only")));
  EXPECT_THAT((*reader)->Retain("state", 1),
              StatusIs(absl::StatusCode::kFailedPrecondition));
}

TEST_F(LocalStoreTest, IsNotFoundWhereThereIsNone) {
  EXPECT_THAT(LocalStore::OpenReadOnly(folder_, clock_),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr(folder_)));
  EXPECT_FALSE(FileExists(folder_));
}

TEST_F(LocalStoreTest, RemovesWhatAKilledWriterLeft) {
  Open();
  const std::string left =
      JoinPath(folder_, "blobs/" + Sha256Hex("x") + ".sinew-tmp-1-0");
  ASSERT_THAT(WriteFileAtomically(left, "half"), IsOk());
  ASSERT_TRUE(IsTemporaryName(left));

  const auto store = Open();

  EXPECT_THAT(Names("blobs"), IsEmpty());
}

TEST_F(LocalStoreTest, NamesFileAndDigestsOfDamagedBytes) {
  const auto store = Open();
  const std::string sha256 = *store->PutBlob(MakeBlob("precious"));
  for (const std::string& bytes : {"precioux", "prec", ""}) {
    ASSERT_THAT(WriteFileAtomically(BlobPath("precious"), bytes), IsOk());

    EXPECT_THAT(store->GetBlob(sha256),
                StatusIs(absl::StatusCode::kDataLoss,
                         AllOf(HasSubstr(BlobPath("precious")),
                               HasSubstr("expected SHA-256 " + sha256),
                               HasSubstr("found " + Sha256Hex(bytes)))));
    EXPECT_EQ(store->OpenBlob(sha256).status(),
              store->GetBlob(sha256).status());
  }
}

TEST_F(LocalStoreTest, HealsDamagedBytesWhenTheyArePutAgain) {
  const auto store = Open();
  for (const std::string& bytes : {"precioux", "prec", "longer than before"}) {
    ASSERT_THAT(WriteFileAtomically(BlobPath("precious"), bytes), IsOk());

    ASSERT_THAT(store->PutBlob(MakeBlob("precious")), IsOk());

    EXPECT_THAT(store->GetBlob(Sha256Hex("precious")), IsOk());
  }
}

TEST_F(LocalStoreTest, ListsADamagedRecordAndGoesOnWithTheOthers) {
  Open()->SetAlias("x", "y").IgnoreError();
  {
    const auto store = Open();
    ASSERT_THAT(Put(*store, "s1"), IsOk());
    ASSERT_THAT(Put(*store, "s2"), IsOk());
  }
  const std::string path = JoinPath(folder_, "artifacts/s2");
  std::string record = *ReadFile(path);
  record[record.size() / 2] ^= 1;
  ASSERT_THAT(WriteFileAtomically(path, record), IsOk());

  const auto store = Open();

  const auto list = store->ListArtifacts("");
  ASSERT_THAT(list, IsOk());
  EXPECT_EQ(list->artifacts_size(), 1);
  EXPECT_THAT(list->damaged(),
              ElementsAre(AllOf(HasSubstr(path), HasSubstr("expected SHA-256"),
                                HasSubstr("found"))));
  EXPECT_THAT(store->GetArtifact("s2"),
              StatusIs(absl::StatusCode::kDataLoss, HasSubstr(path)));
  EXPECT_THAT(GetFiles(*store, "s1"), IsOk());
  EXPECT_THAT(Put(*store, "s2"), IsOk());
  EXPECT_THAT(GetFiles(*store, "s2"), IsOk());
}

TEST_F(LocalStoreTest, ListsATruncatedAlias) {
  {
    const auto store = Open();
    ASSERT_THAT(Put(*store, "s1"), IsOk());
    ASSERT_THAT(store->SetAlias("latest", "s1"), IsOk());
  }
  const std::string path = JoinPath(folder_, "aliases/latest");
  ASSERT_THAT(WriteFileAtomically(path, "sha"), IsOk());

  const auto store = Open();
  EXPECT_THAT(store->ListArtifacts("")->damaged(),
              ElementsAre(HasSubstr(path)));
  EXPECT_THAT(store->GetArtifact("latest"),
              StatusIs(absl::StatusCode::kDataLoss, HasSubstr(path)));
  // It may have named what is old now.
  ASSERT_THAT(Put(*store, "s2"), IsOk());
  ASSERT_THAT(store->Retain("state", 1), IsOk());
  EXPECT_THAT(store->GetArtifact("s1"), IsOk());
}

TEST_F(LocalStoreTest, RefusesTheRecordOfAnotherAlias) {
  {
    const auto store = Open();
    ASSERT_THAT(Put(*store, "s1"), IsOk());
    ASSERT_THAT(store->SetAlias("latest", "s1"), IsOk());
  }
  const std::string record = *ReadFile(JoinPath(folder_, "aliases/latest"));
  ASSERT_THAT(WriteFileAtomically(JoinPath(folder_, "aliases/best"), record),
              IsOk());

  EXPECT_THAT(
      Open()->GetArtifact("best"),
      StatusIs(absl::StatusCode::kDataLoss,
               HasSubstr("aliases/best: expected alias best, found latest")));
}

TEST_F(LocalStoreTest, DoesNotCountABrokenArtifactAmongThoseToKeep) {
  const auto store = Open();
  for (const std::string& id : {"s1", "s2", "s3"}) {
    ASSERT_THAT(Put(*store, id), IsOk());
  }
  ASSERT_EQ(truncate(BlobPath("own of s3").c_str(), 2), 0);

  ASSERT_THAT(store->Retain("state", 1), IsOk());

  EXPECT_THAT(GetFiles(*store, "s2"), IsOk());
  EXPECT_THAT(store->GetArtifact("s1"), StatusIs(absl::StatusCode::kNotFound));
}

TEST_F(LocalStoreTest, CollectsTheBytesOfAWriterThatNeverCameBack) {
  const auto store = Open();
  const std::string sha256 = *store->PutBlob(MakeBlob("orphan"));
  ASSERT_THAT(Put(*store, "s1"), IsOk());

  for (int i = 0; i <= ArtifactIndex::kMaxAge; ++i) {
    ASSERT_THAT(store->Retain("state", 1), IsOk());
  }

  EXPECT_THAT(store->GetBlob(sha256), StatusIs(absl::StatusCode::kNotFound));
  EXPECT_THAT(GetFiles(*store, "s1"), IsOk());
}

TEST_F(LocalStoreTest, CollectsBytesThatWerePutBeforeACrash) {
  ASSERT_THAT(Open()->PutBlob(MakeBlob("orphan")), IsOk());
  const auto store = Open();
  EXPECT_THAT(Names("blobs"), Contains(Sha256Hex("orphan")));

  ASSERT_THAT(store->Retain("state", 1), IsOk());

  EXPECT_THAT(Names("blobs"), IsEmpty());
}

}  // namespace
}  // namespace sinew::checkpoint
