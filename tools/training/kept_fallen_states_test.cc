#include "tools/training/kept_fallen_states.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>

#include "absl/status/status.h"
#include "common/digest.h"
#include "common/testing/matchers.h"
#include "deploy/checkpoint/client/testing/memory_store.h"
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
    checkpoint::ArtifactFiles files;
    for (const auto& [role, bytes] : assets) {
      files[role] = std::make_shared<const std::string>(bytes);
    }
    v1::Artifact record;
    record.set_id(id);
    record.set_kind("assets");
    ASSERT_THAT(PutFiles(store_, record, files), IsOk());
  }
  // What is kept for these assets; empty: nothing.
  std::string Found(const Assets& assets) {
    notes_.clear();
    const Blob blob = FindFallenStates(store_, assets, &notes_);
    return blob == nullptr ? "" : *blob;
  }

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
