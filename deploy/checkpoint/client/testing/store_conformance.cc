#include "deploy/checkpoint/client/testing/store_conformance.h"

#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/digest.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"

namespace sinew::checkpoint {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::IsOkAndHolds;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Pair;
using ::testing::Pointee;

Blob MakeBlob(const std::string& bytes) {
  return std::make_shared<const std::string>(bytes);
}

v1::Artifact MakeRecord(const std::string& id, int64_t iteration = 0,
                        const std::string& kind = "state") {
  v1::Artifact record;
  record.set_id(id);
  record.set_kind(kind);
  record.set_iteration(iteration);
  return record;
}

// An artifact with one file of its own and one that all share.
absl::Status Put(ArtifactStore& store, const std::string& id,
                 const std::string& kind = "state") {
  return PutFiles(
      store, MakeRecord(id, 7, kind),
      {{"own", MakeBlob("own of " + id)}, {"shared", MakeBlob("shared")}});
}

std::vector<std::string> Ids(ArtifactStore& store, const std::string& kind) {
  const auto list = store.ListArtifacts(kind);
  EXPECT_THAT(list, IsOk());
  std::vector<std::string> ids;
  if (!list.ok()) return ids;
  for (const v1::Artifact& artifact : list->artifacts()) {
    ids.push_back(artifact.id());
  }
  return ids;
}

TEST_P(StoreConformance, ReturnsEmptySmallAndLargeBlobsAsTheyWerePut) {
  for (const std::string& bytes :
       {std::string(), std::string("x"), std::string(3 << 20, 'y')}) {
    const auto sha256 = store().PutBlob(MakeBlob(bytes));

    EXPECT_THAT(sha256, IsOkAndHolds(Sha256Hex(bytes)));
    EXPECT_THAT(store().GetBlob(Sha256Hex(bytes)),
                IsOkAndHolds(Pointee(bytes)));
  }
}

TEST_P(StoreConformance, TakesTheSameBlobTwice) {
  EXPECT_THAT(store().PutBlob(MakeBlob("twice")), IsOk());
  EXPECT_THAT(store().PutBlob(MakeBlob("twice")), IsOk());
}

TEST_P(StoreConformance, NamesTheDigestThatIsNotThere) {
  const std::string sha256 = Sha256Hex("absent");

  EXPECT_THAT(store().GetBlob(sha256),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr(sha256)));
}

TEST_P(StoreConformance, RefusesWhatIsNoDigest) {
  EXPECT_THAT(store().GetBlob("../../etc/passwd"),
              StatusIs(absl::StatusCode::kInvalidArgument));
  EXPECT_THAT(store().OpenBlob("../../etc/passwd"),
              StatusIs(absl::StatusCode::kInvalidArgument));
}

TEST_P(StoreConformance, OpensABlobToBeReadInPieces) {
  const std::string sha256 = *store().PutBlob(MakeBlob("abcde"));

  const auto blob = store().OpenBlob(sha256);
  ASSERT_THAT(blob, IsOk());
  ASSERT_THAT(store().DropBlobs({sha256}), IsOk());

  EXPECT_EQ((*blob)->size(), 5);
  EXPECT_THAT((*blob)->Read(1, 3), IsOkAndHolds(std::string("bcd")));
  EXPECT_THAT((*blob)->Read(4, 3), IsOkAndHolds(std::string("e")));
  EXPECT_THAT(store().OpenBlob(sha256), StatusIs(absl::StatusCode::kNotFound));
}

TEST_P(StoreConformance, ReturnsTheFilesOfAnArtifact) {
  const ArtifactFiles files = {{"a.pb", MakeBlob("a")},
                               {"folder/b.bin", MakeBlob("b")}};

  ASSERT_THAT(PutFiles(store(), MakeRecord("state-1", 5), files), IsOk());

  EXPECT_THAT(GetFiles(store(), "state-1"),
              IsOkAndHolds(ElementsAre(
                  Pair("a.pb", Pointee(std::string("a"))),
                  Pair("folder/b.bin", Pointee(std::string("b"))))));
  const auto record = store().GetArtifact("state-1");
  ASSERT_THAT(record, IsOk());
  EXPECT_EQ(record->iteration(), 5);
  EXPECT_EQ(record->sequence(), 1);
  EXPECT_GT(record->created_unix_s(), 0);
}

TEST_P(StoreConformance, RefusesAnArtifactWhoseBlobIsMissing) {
  v1::Artifact record = MakeRecord("state-1");
  v1::Artifact::File& file = *record.add_files();
  file.set_path("a.pb");
  file.set_sha256(Sha256Hex("never put"));
  file.set_size(9);

  EXPECT_THAT(store().PutArtifact(record),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       AllOf(HasSubstr("a.pb"), HasSubstr(file.sha256()))));
  EXPECT_THAT(store().GetArtifact("state-1"),
              StatusIs(absl::StatusCode::kNotFound));
}

TEST_P(StoreConformance, RefusesAnArtifactWhoseSizeIsNotTheBlobs) {
  v1::Artifact record = MakeRecord("state-1");
  v1::Artifact::File& file = *record.add_files();
  file.set_path("a.pb");
  file.set_sha256(*store().PutBlob(MakeBlob("four")));
  file.set_size(5);

  EXPECT_THAT(store().PutArtifact(record),
              StatusIs(absl::StatusCode::kFailedPrecondition));
}

TEST_P(StoreConformance, RefusesMalformedArtifacts) {
  for (const std::string& id : {"", "..", "a/b", ".hidden", "a b"}) {
    EXPECT_THAT(Put(store(), id), StatusIs(absl::StatusCode::kInvalidArgument))
        << id;
  }
  for (const std::string& path : {"", "/etc/x", "../x", "a//b", "a/../b"}) {
    EXPECT_THAT(PutFiles(store(), MakeRecord("id"), {{path, MakeBlob("x")}}),
                StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("path")))
        << path;
  }
  EXPECT_THAT(Put(store(), "id", "Some Kind"),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("kind")));
  EXPECT_THAT(Ids(store(), ""), IsEmpty());
}

TEST_P(StoreConformance, TakesEqualContentAgainAndRefusesAnother) {
  ASSERT_THAT(Put(store(), "state-1"), IsOk());

  EXPECT_THAT(Put(store(), "state-1"), IsOk());
  EXPECT_THAT(PutFiles(store(), MakeRecord("state-1", 7),
                       {{"own", MakeBlob("another")}}),
              StatusIs(absl::StatusCode::kAlreadyExists, HasSubstr("state-1")));
  EXPECT_THAT(GetFiles(store(), "state-1"), IsOk());
}

TEST_P(StoreConformance, ListsNewestFirstAndByKind) {
  ASSERT_THAT(Put(store(), "z-first"), IsOk());
  ASSERT_THAT(Put(store(), "bundle-1", "bundle"), IsOk());
  ASSERT_THAT(Put(store(), "a-last"), IsOk());

  EXPECT_THAT(Ids(store(), "state"), ElementsAre("a-last", "z-first"));
  EXPECT_THAT(Ids(store(), ""), ElementsAre("a-last", "bundle-1", "z-first"));
  EXPECT_THAT(Ids(store(), "assets"), IsEmpty());
}

TEST_P(StoreConformance, FindsAnArtifactByItsAlias) {
  ASSERT_THAT(Put(store(), "state-1"), IsOk());
  ASSERT_THAT(Put(store(), "state-2"), IsOk());

  ASSERT_THAT(store().SetAlias("latest", "state-1"), IsOk());
  ASSERT_THAT(store().SetAlias("latest", "state-2"), IsOk());

  EXPECT_EQ(store().GetArtifact("latest")->id(), "state-2");
  const auto list = store().ListArtifacts("");
  ASSERT_THAT(list, IsOk());
  ASSERT_EQ(list->aliases_size(), 1);
  EXPECT_EQ(list->aliases(0).name(), "latest");
  EXPECT_EQ(list->aliases(0).id(), "state-2");
}

TEST_P(StoreConformance, MovesAnAliasOnlyFromWhereItIsExpected) {
  ASSERT_THAT(Put(store(), "state-1"), IsOk());
  ASSERT_THAT(Put(store(), "state-2"), IsOk());
  ASSERT_THAT(store().SetAlias("stable", "state-1"), IsOk());

  EXPECT_THAT(store().SetAlias("stable", "state-2", "state-0"),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       AllOf(HasSubstr("expected it to point at state-0"),
                             HasSubstr("found state-1"))));
  EXPECT_THAT(store().SetAlias("stable", "state-2", "state-1"), IsOk());
  // The reply was lost, the client asks again.
  EXPECT_THAT(store().SetAlias("stable", "state-2", "state-1"), IsOk());
  EXPECT_EQ(store().GetArtifact("stable")->id(), "state-2");
}

TEST_P(StoreConformance, RefusesAliasesOfNothingAndNamesThatAreTaken) {
  ASSERT_THAT(Put(store(), "state-1"), IsOk());
  ASSERT_THAT(store().SetAlias("latest", "state-1"), IsOk());

  EXPECT_THAT(store().SetAlias("best", "state-9"),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("state-9")));
  EXPECT_THAT(store().SetAlias("state-1", "state-1"),
              StatusIs(absl::StatusCode::kAlreadyExists));
  EXPECT_THAT(store().SetAlias("../x", "state-1"),
              StatusIs(absl::StatusCode::kInvalidArgument));
  EXPECT_THAT(Put(store(), "latest"),
              StatusIs(absl::StatusCode::kAlreadyExists));
}

TEST_P(StoreConformance, RetainsTheNewestOfAKindAndWhatAliasesName) {
  for (const std::string& id : {"s1", "s2", "s3", "s4", "s5"}) {
    ASSERT_THAT(Put(store(), id), IsOk());
  }
  ASSERT_THAT(Put(store(), "b1", "bundle"), IsOk());
  ASSERT_THAT(store().SetAlias("best", "s2"), IsOk());

  ASSERT_THAT(store().Retain("state", 2), IsOk());

  EXPECT_THAT(Ids(store(), ""), ElementsAre("b1", "s5", "s4", "s2"));
  for (const std::string& id : {"s2", "s4", "s5", "b1"}) {
    EXPECT_THAT(GetFiles(store(), id), IsOk()) << id;
  }
  EXPECT_THAT(store().GetBlob(Sha256Hex("own of s1")),
              StatusIs(absl::StatusCode::kNotFound));
}

TEST_P(StoreConformance, RetainsNothingLessThanOne) {
  EXPECT_THAT(store().Retain("state", 0),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("expected >= 1, found 0")));
}

TEST_P(StoreConformance, KeepsBlobsThatWaitForTheirArtifact) {
  const std::string sha256 = *store().PutBlob(MakeBlob("early"));

  ASSERT_THAT(store().Retain("state", 1), IsOk());

  EXPECT_THAT(store().GetBlob(sha256), IsOk());
}

TEST_P(StoreConformance, KeepsASharedBlobWhileAnotherSaveWaitsForIt) {
  ASSERT_THAT(Put(store(), "s1"), IsOk());
  ASSERT_THAT(store().PutBlob(MakeBlob("own of s1")), IsOk());
  ASSERT_THAT(Put(store(), "s2"), IsOk());

  ASSERT_THAT(store().Retain("state", 1), IsOk());

  EXPECT_THAT(store().GetBlob(Sha256Hex("own of s1")), IsOk());
}

TEST_P(StoreConformance, KeepsASharedBlobWhenAnArtifactIsPutTwice) {
  ASSERT_THAT(Put(store(), "s1"), IsOk());
  const auto record = store().GetArtifact("s1");
  ASSERT_THAT(record, IsOk());
  // Of another save.
  ASSERT_THAT(store().PutBlob(MakeBlob("own of s1")), IsOk());

  // The reply was lost, the client asks again.
  ASSERT_THAT(store().PutArtifact(*record), IsOk());
  ASSERT_THAT(Put(store(), "s2"), IsOk());
  ASSERT_THAT(store().Retain("state", 1), IsOk());

  EXPECT_THAT(store().GetBlob(Sha256Hex("own of s1")), IsOk());
}

TEST_P(StoreConformance, DropsBlobsThatNothingElseNeeds) {
  ASSERT_THAT(Put(store(), "s1"), IsOk());
  const std::string alone = *store().PutBlob(MakeBlob("alone"));
  const std::string shared = *store().PutBlob(MakeBlob("shared"));

  ASSERT_THAT(store().DropBlobs({alone, shared}), IsOk());

  EXPECT_THAT(store().GetBlob(alone), StatusIs(absl::StatusCode::kNotFound));
  EXPECT_THAT(store().GetBlob(shared), IsOk());
}

TEST_P(StoreConformance, ServesSeveralWritersAtOnce) {
  std::vector<std::thread> writers;
  std::vector<absl::Status> statuses(4);
  for (int writer = 0; writer < 4; ++writer) {
    writers.emplace_back([this, writer, &statuses] {
      for (int i = 0; i < 5 && statuses[writer].ok(); ++i) {
        statuses[writer].Update(Put(store(), absl::StrCat(writer, "-", i)));
        statuses[writer].Update(store().Retain("state", 30));
        statuses[writer].Update(
            GetFiles(store(), absl::StrCat(writer, "-", i)).status());
      }
    });
  }
  for (std::thread& writer : writers) writer.join();

  for (const absl::Status& status : statuses) EXPECT_THAT(status, IsOk());
  EXPECT_EQ(Ids(store(), "state").size(), 20);
}

}  // namespace

// A test program may link the suite and leave it out.
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(StoreConformance);

}  // namespace sinew::checkpoint
