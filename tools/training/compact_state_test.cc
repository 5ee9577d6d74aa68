#include "tools/training/compact_state.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "absl/status/status.h"
#include "common/clock.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/policy/safetensors.h"
#include "common/rpc/credentials.h"
#include "common/testing/matchers.h"
#include "common/testing/test_files.h"
#include "deploy/checkpoint/client/artifact_store.h"
#include "deploy/checkpoint/open_store.h"
#include "learner/state/state_files.h"
#include "learner/state/state_store.h"
#include "learner/state/testing/make_state.h"
#include "proto/sinew/v1/checkpoint.pb.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "proto/sinew/v1/run.pb.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::sinew::testing::TestPath;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;

// A state with environments, one of them within an episode, and an order out.
learner::Trainer::State State(const std::string& assets) {
  learner::Trainer::State state = learner::MakeState(12);
  state.counters.set_assets_sha256(Sha256Hex(assets));
  state.counters.set_next_order_id(99);
  state.counters.add_environments()->set_episode(4);
  v1::EnvironmentState& under_way = *state.counters.add_environments();
  under_way.set_episode(7);
  under_way.add_physics(1.5);
  state.counters.add_open_orders();
  state.counters.add_pending_evaluations();
  state.counters.mutable_curriculum()->add_clips()->set_name("walk");
  learner::AddChunk("labelled", state);
  state.counters.mutable_memory()->set_inserted_rows(640);
  state.counters.mutable_memory()->set_sampled_rows(2560);
  return state;
}

class CompactStateTest : public ::testing::Test {
 protected:
  CompactStateTest() {
    v1::Asset& asset = *list_.add_assets();
    asset.set_role("library");
    asset.set_sha256(std::string(64, 'a'));
    source_.mutable_bundle()->set_role("teacher");
    source_.mutable_bundle()->set_manifest_sha256("expert");
    from_ = TestPath("checkpoints");
    to_ = TestPath("state");
  }

  void Save(bool with_list) {
    const auto store = checkpoint::OpenStore(
        from_, checkpoint::StoreAccess::kWrite, rpc::Security(), clock_);
    ASSERT_THAT(store, IsOk());
    const std::string assets = list_.SerializeAsString();
    ASSERT_THAT(learner::SaveState(**store, State(assets), /*keep=*/2), IsOk());
    if (!with_list) return;
    ASSERT_THAT((*store)->PutBlob(std::make_shared<const std::string>(assets)),
                IsOk());
  }

  absl::Status Write() const {
    const auto store = checkpoint::OpenStore(
        from_, checkpoint::StoreAccess::kRead, rpc::Security(), clock_);
    if (!store.ok()) return store.status();
    return WriteCompactState(**store, to_, clock_, {source_});
  }

  const SystemClock clock_;
  v1::RunInputs::Source source_;
  v1::TaskAssets list_;
  std::string from_, to_;
};

TEST_F(CompactStateTest, HoldsWhatIsLearnedAndNothingThatIsUnderWay) {
  Save(/*with_list=*/true);

  ASSERT_THAT(Write(), IsOk());
  const auto compact = ReadCompactState(to_, clock_);

  ASSERT_THAT(compact, IsOk());
  const v1::TrainingState& counters = compact->state.counters;
  EXPECT_EQ(counters.iteration(), 12);
  EXPECT_EQ(counters.samples(), 1200);
  EXPECT_EQ(counters.next_order_id(), 99);
  EXPECT_EQ(counters.curriculum().clips(0).name(), "walk");
  EXPECT_EQ(SerializeSafetensors(compact->state.tensors),
            SerializeSafetensors(learner::MakeState(12).tensors));
  EXPECT_THAT(compact->assets,
              ElementsAre(Pair("library", std::string(64, 'a'))));
  EXPECT_EQ(counters.open_orders_size(), 0);
  EXPECT_EQ(counters.pending_evaluations_size(), 0);
  EXPECT_TRUE(compact->state.snapshots.empty());
  ASSERT_EQ(counters.environments_size(), 2);
  // The episode that was under way is over.
  EXPECT_EQ(counters.environments(0).episode(), 4);
  EXPECT_EQ(counters.environments(1).episode(), 8);
  EXPECT_EQ(counters.environments(1).physics_size(), 0);
}

TEST_F(CompactStateTest, ForgetsTheMemoryButNotHowFarItWas) {
  Save(/*with_list=*/true);

  ASSERT_THAT(Write(), IsOk());
  const auto compact = ReadCompactState(to_, clock_);

  ASSERT_THAT(compact, IsOk());
  const v1::MemoryState& memory = compact->state.counters.memory();
  EXPECT_EQ(memory.chunks_size(), 0);
  EXPECT_TRUE(compact->state.chunks.empty());
  EXPECT_EQ(memory.inserted_rows(), 640);
  EXPECT_EQ(memory.sampled_rows(), 2560);
}

TEST_F(CompactStateTest, SaysWhatTheRunLearnsFrom) {
  Save(/*with_list=*/true);

  ASSERT_THAT(Write(), IsOk());
  const auto compact = ReadCompactState(to_, clock_);

  ASSERT_THAT(compact, IsOk());
  ASSERT_TRUE(compact->sources.has_value());
  ASSERT_EQ(compact->sources->size(), 1u);
  EXPECT_EQ((*compact->sources)[0].bundle().role(), "teacher");
  EXPECT_EQ((*compact->sources)[0].bundle().manifest_sha256(), "expert");
}

TEST_F(CompactStateTest, SaysNothingOfSourcesWhereNoneWereWritten) {
  const std::string assets = list_.SerializeAsString();
  checkpoint::ArtifactFiles files =
      learner::StateToFiles(Compact(State(assets)));
  files["assets.pb"] = std::make_shared<const std::string>(assets);
  v1::Artifact record;
  record.set_kind("state");
  record.set_id("state-00000012");
  {
    const auto store = checkpoint::OpenStore(
        to_, checkpoint::StoreAccess::kWrite, rpc::Security(), clock_);
    ASSERT_THAT(store, IsOk());
    ASSERT_THAT(PutFiles(**store, record, files), IsOk());
  }

  const auto compact = ReadCompactState(to_, clock_);

  ASSERT_THAT(compact, IsOk());
  EXPECT_EQ(compact->state.counters.iteration(), 12);
  EXPECT_FALSE(compact->sources.has_value());
}

TEST_F(CompactStateTest, ReplacesNothing) {
  Save(/*with_list=*/true);
  ASSERT_THAT(Write(), IsOk());

  EXPECT_THAT(Write(),
              StatusIs(absl::StatusCode::kAlreadyExists, HasSubstr(to_)));
}

TEST_F(CompactStateTest, NeedsTheListOfTheRunsAssets) {
  Save(/*with_list=*/false);

  EXPECT_THAT(Write(), StatusIs(absl::StatusCode::kDataLoss,
                                HasSubstr("the list of the run's assets")));
  EXPECT_FALSE(FileExists(to_));
}

TEST_F(CompactStateTest, IsRefusedIfItIsAbsentOrDamaged) {
  EXPECT_THAT(ReadCompactState(to_, clock_),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr(to_)));
  Save(/*with_list=*/true);
  ASSERT_THAT(Write(), IsOk());
  const std::string blob =
      JoinPath(JoinPath(to_, "blobs"), Sha256Hex(list_.SerializeAsString()));
  ASSERT_THAT(WriteFileAtomically(blob, "damaged"), IsOk());

  EXPECT_THAT(ReadCompactState(to_, clock_),
              StatusIs(absl::StatusCode::kDataLoss, HasSubstr(to_)));
}

}  // namespace
}  // namespace sinew::tools
