#include "tools/training/kept_fallen_states.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "common/clock.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/stop.h"
#include "common/testing/matchers.h"
#include "common/testing/test_files.h"
#include "deploy/checkpoint/client/artifact_store.h"
#include "deploy/checkpoint/client/testing/memory_store.h"
#include "deploy/checkpoint/local_store.h"
#include "proto/sinew/v1/checkpoint.pb.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Assets = std::map<std::string, std::string>;

class KeptFallenStates : public ::testing::Test {
 protected:
  void Keep(const std::string& id, const Assets& assets) {
    KeepIn(store_, id, assets);
  }
  static void KeepIn(checkpoint::ArtifactStore& store, const std::string& id,
                     const Assets& assets) {
    checkpoint::ArtifactFiles files;
    for (const auto& [role, bytes] : assets) {
      files[role] = std::make_shared<const std::string>(bytes);
    }
    v1::Artifact record;
    record.set_id(id);
    record.set_kind("assets");
    ASSERT_THAT(PutFiles(store, record, files), IsOk());
  }
  // What is kept for these assets; empty: nothing.
  std::string Found(const Assets& assets) {
    notes_.clear();
    const Blob blob = FindFallenStates(store_, assets, &notes_);
    return blob == nullptr ? "" : *blob;
  }

  const SystemClock clock_;
  const Assets assets_ = {
      {"character", "c"}, {"model", "m"}, {"recipe", "r"}, {"library", "l"}};
  checkpoint::MemoryStore store_;
  std::vector<std::string> notes_;
};

TEST_F(KeptFallenStates, AreFoundBesideTheSameCharacterModelAndRecipe) {
  EXPECT_EQ(Found(assets_), "");
  EXPECT_THAT(notes_, IsEmpty());
  Assets kept = assets_;
  kept["fallen"] = "states";
  kept["library"] = "another library";
  Keep("assets-1", kept);

  EXPECT_EQ(Found(assets_), "states");
  EXPECT_THAT(notes_, IsEmpty());
}

TEST_F(KeptFallenStates, AreNotThoseOfAnotherCharacterModelOrRecipe) {
  Assets kept = assets_;
  kept["fallen"] = "states";
  Keep("assets-1", kept);
  for (const char* role : {"character", "model", "recipe"}) {
    Assets changed = assets_;
    changed[role] = "another";

    EXPECT_EQ(Found(changed), "") << role;
    EXPECT_THAT(notes_, ElementsAre(AllOf(
                            HasSubstr("assets-1"),
                            HasSubstr(std::string("of another ") + role))));
  }
}

TEST_F(KeptFallenStates, AreNotTakenIfTheyAreDamaged) {
  Assets kept = assets_;
  kept["fallen"] = "states";
  Keep("assets-1", kept);
  store_.Damage(Sha256Hex("states"));

  EXPECT_EQ(Found(assets_), "");
  EXPECT_THAT(notes_, ElementsAre(AllOf(HasSubstr("made anew"),
                                        HasSubstr("expected SHA-256"))));
}

TEST_F(KeptFallenStates, AreNotTakenIfTheyCannotBeRead) {
  Assets kept = assets_;
  kept["fallen"] = "states";
  Keep("assets-1", kept);
  store_.FailReads(absl::UnavailableError("the disk is away"));

  EXPECT_EQ(Found(assets_), "");
  EXPECT_THAT(notes_, ElementsAre(AllOf(HasSubstr("made anew"),
                                        HasSubstr("the disk is away"))));
}

TEST_F(KeptFallenStates, OfADamagedRecordArePassedOver) {
  Assets kept = assets_;
  kept["fallen"] = "states";
  const std::string folder = ::sinew::testing::TestPath("checkpoints");
  {
    const auto store = checkpoint::LocalStore::Open(folder, clock_);
    ASSERT_THAT(store, IsOk());
    KeepIn(**store, "assets-1", kept);
  }
  const std::string record = JoinPath(folder, "artifacts/assets-1");
  std::string bytes = ReadFile(record).value_or("");
  ASSERT_FALSE(bytes.empty());
  bytes[bytes.size() / 2] ^= 1;
  ASSERT_THAT(WriteFileAtomically(record, bytes), IsOk());
  const auto store = checkpoint::LocalStore::OpenReadOnly(folder, clock_);
  ASSERT_THAT(store, IsOk());

  EXPECT_EQ(FindFallenStates(**store, assets_, &notes_), nullptr);

  EXPECT_THAT(notes_,
              ElementsAre(AllOf(HasSubstr("passed over a damaged record"),
                                HasSubstr(record))));
}

TEST_F(KeptFallenStates, AreFoundInARunsFolderIfThereIsOne) {
  Assets kept = assets_;
  kept["fallen"] = "states";
  const std::string folder = ::sinew::testing::TestPath("checkpoints");
  const auto find = [&] {
    return FindFallenStatesAt({.folder = folder}, clock_, StopToken(), assets_,
                              &notes_);
  };
  EXPECT_EQ(find(), nullptr);
  EXPECT_FALSE(FileExists(folder));
  {
    const auto store = checkpoint::LocalStore::Open(folder, clock_);
    ASSERT_THAT(store, IsOk());
    KeepIn(**store, "assets-1", kept);
  }

  const Blob found = find();

  ASSERT_NE(found, nullptr);
  EXPECT_EQ(*found, "states");
  EXPECT_THAT(notes_, IsEmpty());
}

TEST_F(KeptFallenStates, AreFoundAmongAssetsOfSeveralTasks) {
  Assets first = assets_;
  first["fallen"] = "states";
  Keep("assets-1", first);
  Assets second = first;
  second["recipe"] = "another";
  second["fallen"] = "other states";
  Keep("assets-2", second);
  Keep("assets-3", assets_);  // none at all

  EXPECT_EQ(Found(assets_), "states");
  EXPECT_THAT(notes_, IsEmpty());
}

}  // namespace
}  // namespace sinew::tools
