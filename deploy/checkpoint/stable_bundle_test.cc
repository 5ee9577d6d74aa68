#include "deploy/checkpoint/stable_bundle.h"

#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "common/clock.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "common/testing/matchers.h"
#include "common/testing/test_files.h"
#include "deploy/checkpoint/client/artifact_store.h"
#include "deploy/checkpoint/local_store.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::checkpoint {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::IsOkAndHolds;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;

// A store with bundles "a", "b", "c" and a state "s".
class StableBundleTest : public ::testing::Test {
 protected:
  StableBundleTest() {
    store_ = *LocalStore::Open(sinew::testing::TestPath("store"), clock_);
    for (const char* id : {"a", "b", "c"}) Put(id, kBundleKind);
    Put("s", "state");
  }

  void Put(const std::string& id, const std::string& kind) {
    v1::Artifact record;
    record.set_id(id);
    record.set_kind(kind);
    EXPECT_THAT(
        PutFiles(*store_, record,
                 {{"manifest.json", std::make_shared<const std::string>(id)}}),
        IsOk());
  }

  std::string Previous() {
    const auto artifact = store_->GetArtifact(kStablePrevious);
    return artifact.ok() ? artifact->id() : "";
  }

  const SystemClock clock_;
  std::unique_ptr<ArtifactStore> store_;
};

// A store in which something happens right after an alias was set.
class OvertakenStore final : public ArtifactStore {
 public:
  using AfterAlias = std::function<absl::Status(const std::string& alias)>;

  OvertakenStore(ArtifactStore& store, AfterAlias after)
      : store_(store), after_(std::move(after)) {}

  // That alias cannot be set.
  void FailToSet(const std::string& alias) { failing_ = alias; }

  absl::StatusOr<Blob> GetBlob(const std::string& sha256) override {
    return store_.GetBlob(sha256);
  }
  absl::StatusOr<std::string> PutBlob(const Blob& blob) override {
    return store_.PutBlob(blob);
  }
  absl::Status PutArtifact(const v1::Artifact& artifact) override {
    return store_.PutArtifact(artifact);
  }
  absl::StatusOr<v1::Artifact> GetArtifact(const std::string& name) override {
    return store_.GetArtifact(name);
  }
  absl::StatusOr<v1::ListArtifactsResponse> ListArtifacts(
      const std::string& kind) override {
    return store_.ListArtifacts(kind);
  }
  absl::Status SetAlias(const std::string& alias, const std::string& id,
                        const std::string& expected_id) override {
    if (alias == failing_) return absl::ResourceExhaustedError("no room");
    SINEW_RETURN_IF_ERROR(store_.SetAlias(alias, id, expected_id));
    return after_(alias);
  }
  absl::Status Retain(const std::string& kind, int keep) override {
    return store_.Retain(kind, keep);
  }
  absl::Status DropBlobs(absl::Span<const std::string> sha256s) override {
    return store_.DropBlobs(sha256s);
  }

 private:
  ArtifactStore& store_;
  const AfterAlias after_;
  std::string failing_;
};

TEST_F(StableBundleTest, SeesThatAnotherFirstOneCameAfterIt) {
  OvertakenStore overtaken(*store_, [this](const std::string& alias) {
    return store_->SetAlias(alias, "b");
  });

  EXPECT_THAT(MoveStable(overtaken, "a", ""),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("alias \"stable\": expected a, found b")));
  EXPECT_THAT(StableBundle(*store_), IsOkAndHolds("b"));
}

TEST_F(StableBundleTest, IsNoneAtFirst) {
  EXPECT_THAT(StableBundle(*store_), IsOkAndHolds(""));
}

TEST_F(StableBundleTest, IsNotNoneWhereItsRecordIsDamaged) {
  ASSERT_THAT(MoveStable(*store_, "a", ""), IsOk());
  store_.reset();
  const std::string folder = sinew::testing::TestPath("store");
  ASSERT_THAT(WriteFileAtomically(JoinPath(folder, "aliases/stable"), "sha"),
              IsOk());
  store_ = *LocalStore::Open(folder, clock_);
  const auto is_damaged =
      StatusIs(absl::StatusCode::kDataLoss, HasSubstr("aliases/stable"));

  EXPECT_THAT(StableBundle(*store_), is_damaged);
  EXPECT_THAT(MoveStable(*store_, "b", ""), is_damaged);
}

TEST(CheckArtifactId, RefusesWhatIsNoIdOrAnAlias) {
  EXPECT_THAT(CheckArtifactId("bundle-1"), IsOk());
  for (const char* id : {"stable", "stable-previous", "best", "latest"}) {
    EXPECT_THAT(CheckArtifactId(id),
                StatusIs(absl::StatusCode::kInvalidArgument,
                         HasSubstr("the name of an alias")))
        << id;
  }
  EXPECT_THAT(CheckArtifactId("../x"),
              StatusIs(absl::StatusCode::kInvalidArgument));
}

TEST_F(StableBundleTest, MovesAndRemembersWhatItWas) {
  ASSERT_THAT(MoveStable(*store_, "a", ""), IsOk());
  EXPECT_EQ(Previous(), "");

  ASSERT_THAT(MoveStable(*store_, "b", "a"), IsOk());

  EXPECT_THAT(StableBundle(*store_), IsOkAndHolds("b"));
  EXPECT_EQ(Previous(), "a");
}

TEST_F(StableBundleTest, StaysWhereSomebodyElseMovedIt) {
  ASSERT_THAT(MoveStable(*store_, "a", ""), IsOk());
  ASSERT_THAT(MoveStable(*store_, "b", "a"), IsOk());

  EXPECT_THAT(MoveStable(*store_, "c", "a"),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       AllOf(HasSubstr("alias \"stable\": expected a, found b"),
                             HasSubstr("it has moved"))));
  EXPECT_THAT(MoveStable(*store_, "c", ""),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("expected none, found b")));

  EXPECT_THAT(StableBundle(*store_), IsOkAndHolds("b"));
  EXPECT_EQ(Previous(), "a");
}

// Between its two steps somebody else moves the stable one, and has the way
// back.
TEST_F(StableBundleTest, LeavesTheWayBackToWhoeverOvertakesIt) {
  Put("d", kBundleKind);
  ASSERT_THAT(MoveStable(*store_, "a", ""), IsOk());
  ASSERT_THAT(MoveStable(*store_, "b", "a"), IsOk());
  OvertakenStore overtaken(*store_, [this](const std::string& alias) {
    return alias == kStablePrevious ? MoveStable(*store_, "d", "b")
                                    : absl::OkStatus();
  });

  EXPECT_THAT(MoveStable(overtaken, "c", "b"),
              StatusIs(absl::StatusCode::kFailedPrecondition));

  EXPECT_THAT(StableBundle(*store_), IsOkAndHolds("d"));
  EXPECT_EQ(Previous(), "b");
}

TEST_F(StableBundleTest, KeepsTheWayBackWhereTheStoreFails) {
  ASSERT_THAT(MoveStable(*store_, "a", ""), IsOk());
  ASSERT_THAT(MoveStable(*store_, "b", "a"), IsOk());
  OvertakenStore full(
      *store_, [](const std::string& /*alias*/) { return absl::OkStatus(); });
  full.FailToSet(kStable);

  EXPECT_THAT(MoveStable(full, "c", "b"),
              StatusIs(absl::StatusCode::kResourceExhausted));

  EXPECT_THAT(StableBundle(*store_), IsOkAndHolds("b"));
  EXPECT_EQ(Previous(), "a");
}

TEST_F(StableBundleTest, ForgetsNothingWhenItMovesToWhereItIs) {
  ASSERT_THAT(MoveStable(*store_, "a", ""), IsOk());
  ASSERT_THAT(MoveStable(*store_, "b", "a"), IsOk());

  EXPECT_THAT(MoveStable(*store_, "b", "b"), IsOk());

  EXPECT_EQ(Previous(), "a");
}

TEST_F(StableBundleTest, RollsBackOnceAndNoFurther) {
  ASSERT_THAT(MoveStable(*store_, "a", ""), IsOk());
  ASSERT_THAT(MoveStable(*store_, "b", "a"), IsOk());

  EXPECT_THAT(RollBackStable(*store_), IsOkAndHolds("a"));

  EXPECT_THAT(StableBundle(*store_), IsOkAndHolds("a"));
  EXPECT_THAT(RollBackStable(*store_),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("to go back to, found a")));
}

TEST_F(StableBundleTest, HasNothingToGoBackToAtFirst) {
  ASSERT_THAT(MoveStable(*store_, "a", ""), IsOk());

  EXPECT_THAT(RollBackStable(*store_),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("alias \"stable-previous\": expected another "
                                 "bundle than the stable one")));
}

TEST_F(StableBundleTest, RefusesAnAliasOfSomethingElse) {
  ASSERT_THAT(store_->SetAlias(kStable, "s"), IsOk());

  EXPECT_THAT(
      StableBundle(*store_),
      StatusIs(absl::StatusCode::kFailedPrecondition,
               HasSubstr("expected an artifact of kind \"bundle\", found s of "
                         "kind \"state\"")));
}

TEST_F(StableBundleTest, KeepsBothBundlesFromBeingCollected) {
  ASSERT_THAT(MoveStable(*store_, "a", ""), IsOk());
  ASSERT_THAT(MoveStable(*store_, "b", "a"), IsOk());

  ASSERT_THAT(store_->Retain(kBundleKind, 1), IsOk());

  EXPECT_THAT(store_->GetArtifact("a"), IsOk());
  EXPECT_THAT(store_->GetArtifact("b"), IsOk());
}

}  // namespace
}  // namespace sinew::checkpoint
