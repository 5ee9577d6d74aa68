#include "learner/state/state_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <memory>

#include "common/digest.h"
#include "common/policy/safetensors.h"
#include "common/testing/matchers.h"
#include "learner/state/testing/make_state.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::EqualsProto;
using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Key;

Blob MakeBlob(const std::string& bytes) {
  return std::make_shared<const std::string>(bytes);
}

TEST(StateFiles, HoldTheWholeState) {
  const Trainer::State state = MakeState(40);

  const auto files = StateToFiles(state);
  const auto back = StateFromFiles(files);

  EXPECT_THAT(files, ElementsAre(Key("snapshot-40"), Key("state.pb"),
                                 Key("tensors.safetensors")));
  ASSERT_THAT(back, IsOk());
  EXPECT_THAT(back->counters, EqualsProto(state.counters));
  EXPECT_EQ(back->snapshots, state.snapshots);
  ASSERT_TRUE(back->tensors.contains("weight"));
  EXPECT_EQ(back->tensors.at("weight").data, state.tensors.at("weight").data);
  EXPECT_EQ(back->tensors.at("weight").shape, state.tensors.at("weight").shape);
}

TEST(StateFiles, HaveTheSameBytesForTheSameState) {
  const auto one = StateToFiles(MakeState(3));
  const auto two = StateToFiles(MakeState(3));

  for (const auto& [path, blob] : one) EXPECT_EQ(*blob, *two.at(path)) << path;
}

TEST(StateFiles, NameTheFileThatIsMissing) {
  for (const std::string path :
       {"state.pb", "tensors.safetensors", "snapshot-5"}) {
    auto files = StateToFiles(MakeState(5));
    files.erase(path);

    EXPECT_THAT(StateFromFiles(files),
                StatusIs(absl::StatusCode::kDataLoss, HasSubstr(path)));
  }
}

TEST(StateFiles, RefuseWhatIsNoTrainingState) {
  auto files = StateToFiles(MakeState(5));
  files["state.pb"] = MakeBlob("\xff\xff");

  EXPECT_THAT(StateFromFiles(files),
              StatusIs(absl::StatusCode::kDataLoss, HasSubstr("state.pb")));
}

TEST(StateFiles, RefuseNumbersThatAreNotFinite) {
  Trainer::State state = MakeState(5);
  state.tensors.at("weight").mutable_float32()[1] =
      std::numeric_limits<float>::quiet_NaN();

  EXPECT_THAT(StateFromFiles(StateToFiles(state)),
              StatusIs(absl::StatusCode::kDataLoss, HasSubstr("weight")));
}

TEST(StateFiles, RefuseASnapshotOfAnotherDigest) {
  auto files = StateToFiles(MakeState(5));
  files["snapshot-5"] = MakeBlob("another");

  EXPECT_THAT(StateFromFiles(files),
              StatusIs(absl::StatusCode::kDataLoss,
                       AllOf(HasSubstr("snapshot-5: expected SHA-256"),
                             HasSubstr(Sha256Hex("another")))));
}

TEST(StateFiles, HoldTheMemoryInChunksOfTheirOwn) {
  Trainer::State state = MakeState(5);
  AddChunk("first", state);
  AddChunk("second", state);

  const auto files = StateToFiles(state);
  const auto back = StateFromFiles(files);

  EXPECT_TRUE(files.contains("memory-" + Sha256Hex("second")));
  ASSERT_THAT(back, IsOk());
  ASSERT_EQ(back->chunks.size(), 2u);
  EXPECT_EQ(*back->chunks[0].bytes, "first");
  EXPECT_EQ(back->chunks[1].sha256, Sha256Hex("second"));
}

TEST(StateFiles, RefuseAChunkThatIsMissingOrAnother) {
  Trainer::State state = MakeState(5);
  AddChunk("first", state);
  const std::string path = "memory-" + Sha256Hex("first");

  auto missing = StateToFiles(state);
  missing.erase(path);
  auto other = StateToFiles(state);
  other[path] = MakeBlob("another");

  EXPECT_THAT(StateFromFiles(missing),
              StatusIs(absl::StatusCode::kDataLoss, HasSubstr(path)));
  EXPECT_THAT(StateFromFiles(other),
              StatusIs(absl::StatusCode::kDataLoss,
                       HasSubstr(path + ": expected SHA-256")));
}

}  // namespace
}  // namespace sinew::learner
