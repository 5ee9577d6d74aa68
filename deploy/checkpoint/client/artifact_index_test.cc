#include "deploy/checkpoint/client/artifact_index.h"

#include <string>

#include "common/digest.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::checkpoint {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

v1::Artifact MakeArtifact(const std::string& id) {
  v1::Artifact artifact;
  artifact.set_id(id);
  artifact.set_kind("state");
  v1::Artifact::File& file = *artifact.add_files();
  file.set_path("a");
  file.set_sha256(Sha256Hex(id));
  return artifact;
}

void Add(ArtifactIndex& index, const std::string& id) {
  const auto record = index.Admit(MakeArtifact(id), /*now_unix_s=*/5);
  ASSERT_THAT(record, IsOk());
  index.Insert(*record);
}

TEST(ArtifactIndex, NumbersAndDatesWhatItAdmits) {
  ArtifactIndex index;
  Add(index, "a");
  v1::Artifact dated = MakeArtifact("b");
  dated.set_created_unix_s(3);

  EXPECT_EQ(index.Get("a")->sequence(), 1);
  EXPECT_EQ(index.Get("a")->created_unix_s(), 5);
  EXPECT_EQ(index.Admit(dated, 5)->sequence(), 2);
  EXPECT_EQ(index.Admit(dated, 5)->created_unix_s(), 3);
}

TEST(ArtifactIndex, AdmitsEqualContentAsItIs) {
  ArtifactIndex index;
  Add(index, "a");

  EXPECT_EQ(index.Admit(MakeArtifact("a"), 9)->created_unix_s(), 5);
}

TEST(ArtifactIndex, NeedsABlobWhileAnArtifactNamesIt) {
  ArtifactIndex index;
  Add(index, "a");
  EXPECT_TRUE(index.IsNeeded(Sha256Hex("a")));

  index.Erase("a");

  EXPECT_FALSE(index.IsNeeded(Sha256Hex("a")));
}

TEST(ArtifactIndex, NeedsABlobUntilEveryHoldOfItEnds) {
  ArtifactIndex index;
  index.Hold("x");
  index.Hold("x");

  index.Release("x");
  EXPECT_TRUE(index.IsNeeded("x"));
  index.Release("x");
  EXPECT_FALSE(index.IsNeeded("x"));
  index.Release("x");
  EXPECT_FALSE(index.IsNeeded("x"));
}

TEST(ArtifactIndex, EndsAHoldThatIsTooOld) {
  ArtifactIndex index;
  index.Hold("x");
  for (int i = 0; i < ArtifactIndex::kMaxAge; ++i) index.Age();
  EXPECT_TRUE(index.IsNeeded("x"));

  index.Age();

  EXPECT_FALSE(index.IsNeeded("x"));
}

TEST(ArtifactIndex, FindsTheSurplusBeyondTheNewestWholeOnes) {
  ArtifactIndex index;
  for (const char* id : {"a", "b", "c", "d"}) Add(index, id);
  index.InsertAlias("best", "a");

  // d is broken, so c is the newest whole one.
  const auto surplus = index.Surplus(
      "state", 1, [](const v1::Artifact& one) { return one.id() != "d"; });

  EXPECT_THAT(surplus, ElementsAre("b"));
}

TEST(ArtifactIndex, SaysWhatAnAliasOfNothingNames) {
  ArtifactIndex index;
  index.InsertAlias("latest", "gone");

  EXPECT_THAT(
      index.Get("latest"),
      StatusIs(absl::StatusCode::kDataLoss,
               HasSubstr("alias latest: expected an artifact, found none of "
                         "the id that it names, gone")));
}

TEST(ArtifactIndex, KnowsNotWhereADamagedAliasPoints) {
  ArtifactIndex index;
  for (const char* id : {"a", "b"}) Add(index, id);
  index.InsertDamagedAlias("best", "aliases/best: truncated");
  const auto is_damaged = StatusIs(absl::StatusCode::kDataLoss,
                                   HasSubstr("aliases/best: truncated"));

  EXPECT_THAT(index.Get("best"), is_damaged);
  EXPECT_THAT(index.CheckAlias("best", "b", /*expected_id=*/"a"), is_damaged);
  EXPECT_THAT(index.Surplus("state", 1, [](const auto&) { return true; }),
              IsEmpty());
  EXPECT_THAT(index.List("").damaged(), ElementsAre("aliases/best: truncated"));

  EXPECT_THAT(index.Admit(MakeArtifact("best"), /*now_unix_s=*/5),
              StatusIs(absl::StatusCode::kAlreadyExists,
                       HasSubstr("aliases/best: truncated")));

  // Set anew, it is whole.
  ASSERT_THAT(index.CheckAlias("best", "b", /*expected_id=*/""), IsOk());
  index.InsertAlias("best", "b");

  EXPECT_THAT(index.Get("best"), IsOk());
  EXPECT_THAT(index.Surplus("state", 1, [](const auto&) { return true; }),
              ElementsAre("a"));
  EXPECT_THAT(index.List("").damaged(), IsEmpty());
}

}  // namespace
}  // namespace sinew::checkpoint
