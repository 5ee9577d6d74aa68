#include "learner/state/state_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/digest.h"
#include "common/testing/matchers.h"
#include "deploy/checkpoint/client/testing/memory_store.h"
#include "learner/state/newest_state.h"
#include "learner/state/state_files.h"
#include "learner/state/testing/make_state.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::vector<std::string> Ids(checkpoint::ArtifactStore& store) {
  std::vector<std::string> ids;
  const auto list = store.ListArtifacts("state");
  EXPECT_THAT(list, IsOk());
  for (const v1::Artifact& artifact : list->artifacts()) {
    ids.push_back(artifact.id());
  }
  return ids;
}

std::string TensorsDigest(const Trainer::State& state) {
  return Sha256Hex(*StateToFiles(state).at("tensors.safetensors"));
}

class StateStore : public ::testing::Test {
 protected:
  // Iteration of the latest state that loads.
  absl::StatusOr<int64_t> LoadedIteration() {
    const auto state = LoadLatestState(store_, &warnings_);
    if (!state.ok()) return state.status();
    return state->counters.iteration();
  }

  checkpoint::MemoryStore store_;
  std::vector<std::string> warnings_;
};

TEST_F(StateStore, StoresAChunkOnceForAllStatesThatHaveIt) {
  Trainer::State first = MakeState(20);
  AddChunk("old", first);
  AddChunk("shared", first);
  Trainer::State second = MakeState(40);
  AddChunk("shared", second);
  AddChunk("new", second);
  ASSERT_THAT(SaveState(store_, first, 1), IsOk());
  ASSERT_THAT(SaveState(store_, second, 1), IsOk());

  const auto state = LoadLatestState(store_, &warnings_);

  ASSERT_THAT(state, IsOk());
  ASSERT_EQ(state->chunks.size(), 2u);
  EXPECT_EQ(*state->chunks[0].bytes, "shared");
  EXPECT_EQ(*state->chunks[1].bytes, "new");
  // What no state has any more is gone.
  EXPECT_THAT(store_.GetBlob(Sha256Hex("shared")), IsOk());
  EXPECT_THAT(store_.GetBlob(Sha256Hex("old")),
              StatusIs(absl::StatusCode::kNotFound));
}

TEST_F(StateStore, ReturnsTheNewestState) {
  ASSERT_THAT(SaveState(store_, MakeState(20), 3), IsOk());
  ASSERT_THAT(SaveState(store_, MakeState(40), 3), IsOk());

  const auto state = LoadLatestState(store_, &warnings_);

  ASSERT_THAT(state, IsOk());
  EXPECT_EQ(state->counters.iteration(), 40);
  EXPECT_EQ(state->tensors.at("weight").data,
            MakeState(40).tensors.at("weight").data);
  EXPECT_THAT(state->snapshots, ElementsAre("snapshot of 40"));
  EXPECT_THAT(warnings_, IsEmpty());
  EXPECT_EQ(store_.GetArtifact("latest")->id(), "state-00000040");
}

TEST_F(StateStore, KeepsAsManyAsAskedAndWhatAnAliasNames) {
  ASSERT_THAT(SaveState(store_, MakeState(1), 2), IsOk());
  ASSERT_THAT(store_.SetAlias("kept", "state-00000001"), IsOk());
  for (int iteration : {2, 3, 4}) {
    ASSERT_THAT(SaveState(store_, MakeState(iteration), 2), IsOk());
  }

  EXPECT_THAT(Ids(store_), ElementsAre("state-00000004", "state-00000003",
                                       "state-00000001"));
  EXPECT_EQ(store_.GetArtifact("kept")->iteration(), 1);
}

TEST_F(StateStore, FallsBackToTheOlderStateWhenTheNewerIsDamaged) {
  ASSERT_THAT(SaveState(store_, MakeState(1), 3), IsOk());
  ASSERT_THAT(SaveState(store_, MakeState(2), 3), IsOk());
  const std::string digest = TensorsDigest(MakeState(2));
  store_.Damage(digest);

  EXPECT_EQ(*LoadedIteration(), 1);

  EXPECT_THAT(
      warnings_,
      ElementsAre(AllOf(HasSubstr("passed over state-00000002"),
                        HasSubstr("tensors.safetensors"),
                        HasSubstr("expected SHA-256 " + digest + ", found"))));
}

TEST_F(StateStore, SavesAnIterationAgainWhoseStateWasDamaged) {
  ASSERT_THAT(SaveState(store_, MakeState(1), 3), IsOk());
  ASSERT_THAT(SaveState(store_, MakeState(2), 3), IsOk());
  store_.Damage(TensorsDigest(MakeState(2)));
  ASSERT_EQ(*LoadedIteration(), 1);
  // The run goes on from 1; times differ, weights do not.
  Trainer::State again = MakeState(2);
  again.counters.set_wall_seconds(5);

  ASSERT_THAT(SaveState(store_, again, 3), IsOk());

  EXPECT_THAT(Ids(store_), ElementsAre("state-00000002-2", "state-00000002",
                                       "state-00000001"));
  EXPECT_EQ(store_.GetArtifact("latest")->id(), "state-00000002-2");
  EXPECT_EQ(LoadLatestState(store_, &warnings_)->counters.wall_seconds(), 5);
}

TEST_F(StateStore, SavesTheSameStateTwiceWithoutHarm) {
  ASSERT_THAT(SaveState(store_, MakeState(1), 3), IsOk());
  ASSERT_THAT(SaveState(store_, MakeState(1), 3), IsOk());

  EXPECT_THAT(Ids(store_), ElementsAre("state-00000001"));
}

TEST_F(StateStore, KeepsTheOldStateWhenThereIsNoRoom) {
  ASSERT_THAT(SaveState(store_, MakeState(1, 1000), 1), IsOk());
  const int64_t before = store_.bytes();
  store_.LimitBytes(before + 4000);

  EXPECT_THAT(SaveState(store_, MakeState(2, 1000), 1),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       HasSubstr("state-00000002")));

  EXPECT_EQ(store_.bytes(), before);
  EXPECT_EQ(*LoadedIteration(), 1);
}

TEST_F(StateStore, MakesRoomWithTheOldestState) {
  ASSERT_THAT(SaveState(store_, MakeState(1, 1000), 2), IsOk());
  ASSERT_THAT(SaveState(store_, MakeState(2, 1000), 2), IsOk());
  store_.LimitBytes(store_.bytes() + 2000);

  EXPECT_THAT(SaveState(store_, MakeState(3, 1000), 2), IsOk());

  EXPECT_THAT(Ids(store_), ElementsAre("state-00000003", "state-00000002"));
}

TEST_F(StateStore, ReadsTheNewestCountersWithoutTensors) {
  ASSERT_THAT(SaveState(store_, MakeState(1), 3), IsOk());
  ASSERT_THAT(SaveState(store_, MakeState(2), 3), IsOk());
  store_.Damage(TensorsDigest(MakeState(2)));

  const auto counters = LoadLatestCounters(store_, &warnings_);

  ASSERT_THAT(counters, IsOk());
  EXPECT_EQ(counters->samples(), 200);
  EXPECT_THAT(warnings_, IsEmpty());
}

TEST_F(StateStore, ReadsOlderCountersWhenTheNewerAreDamaged) {
  EXPECT_THAT(LoadLatestCounters(store_, &warnings_),
              StatusIs(absl::StatusCode::kNotFound));
  ASSERT_THAT(SaveState(store_, MakeState(1), 3), IsOk());
  ASSERT_THAT(SaveState(store_, MakeState(2), 3), IsOk());
  store_.Damage(Sha256Hex(*StateToFiles(MakeState(2)).at("state.pb")));

  const auto counters = LoadLatestCounters(store_, &warnings_);

  ASSERT_THAT(counters, IsOk());
  EXPECT_EQ(counters->iteration(), 1);
  EXPECT_THAT(warnings_, ElementsAre(HasSubstr("passed over state-00000002")));
}

TEST_F(StateStore, SaysWhenThereIsNone) {
  EXPECT_THAT(LoadedIteration(), StatusIs(absl::StatusCode::kNotFound));
  EXPECT_THAT(warnings_, IsEmpty());
}

TEST_F(StateStore, DoesNotTakeEarlierWarningsForDamagedStates) {
  warnings_ = {"of another store"};

  EXPECT_THAT(LoadedIteration(), StatusIs(absl::StatusCode::kNotFound));
  EXPECT_THAT(warnings_, ElementsAre("of another store"));
}

TEST_F(StateStore, DoesNotTakeDamagedStatesForNone) {
  ASSERT_THAT(SaveState(store_, MakeState(1), 3), IsOk());
  store_.Damage(TensorsDigest(MakeState(1)));

  EXPECT_THAT(LoadedIteration(), StatusIs(absl::StatusCode::kDataLoss,
                                          HasSubstr("only damaged ones")));
}

TEST_F(StateStore, DoesNotTakeAnAbsentStoreForDamage) {
  ASSERT_THAT(SaveState(store_, MakeState(1), 3), IsOk());
  store_.FailReads(absl::UnavailableError("the peer is away"));

  EXPECT_THAT(LoadedIteration(), StatusIs(absl::StatusCode::kUnavailable));
  EXPECT_THAT(warnings_, IsEmpty());
}

}  // namespace
}  // namespace sinew::learner
