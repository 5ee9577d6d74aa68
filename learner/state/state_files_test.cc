#include "learner/state/state_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/digest.h"
#include "common/files.h"
#include "common/testing/matchers.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Trainer::State MakeState(int64_t iteration) {
  Trainer::State state;
  state.counters.set_iteration(iteration);
  state.counters.set_samples(100 * iteration);
  auto& reference = *state.counters.add_snapshots();
  reference.set_version(iteration);
  state.snapshots.push_back("snapshot bytes");
  reference.set_sha256(Sha256Hex(state.snapshots.back()));
  state.tensors["weight"] = HostTensor::Zeros({2, 3});
  return state;
}

std::string Folder() {
  return JoinPath(
      ::testing::TempDir(),
      ::testing::UnitTest::GetInstance()->current_test_info()->name());
}

TEST(StateFiles, ReturnTheNewestState) {
  ASSERT_THAT(SaveState(Folder(), MakeState(20), 3), IsOk());
  ASSERT_THAT(SaveState(Folder(), MakeState(40), 3), IsOk());
  std::vector<std::string> warnings;

  auto state = LoadLatestState(Folder(), &warnings);

  ASSERT_THAT(state, IsOk());
  EXPECT_EQ(state->counters.iteration(), 40);
  EXPECT_EQ(state->tensors.at("weight").shape, (std::vector<int64_t>{2, 3}));
  EXPECT_THAT(state->snapshots, ElementsAre("snapshot bytes"));
  EXPECT_THAT(warnings, IsEmpty());
}

TEST(StateFiles, KeepAsManyAsAsked) {
  for (int iteration : {1, 2, 3, 4}) {
    ASSERT_THAT(SaveState(Folder(), MakeState(iteration), 2), IsOk());
  }

  EXPECT_THAT(*ListDirectory(Folder()),
              ElementsAre("state-00000003", "state-00000004"));
}

TEST(StateFiles, FallBackToTheOlderStateWhenTheNewerIsDamaged) {
  ASSERT_THAT(SaveState(Folder(), MakeState(1), 3), IsOk());
  ASSERT_THAT(SaveState(Folder(), MakeState(2), 3), IsOk());
  const std::string file =
      JoinPath(Folder(), "state-00000002/tensors.safetensors");
  std::string bytes = *ReadFile(file);
  bytes.back() ^= 1;
  ASSERT_THAT(WriteFileAtomically(file, bytes), IsOk());
  std::vector<std::string> warnings;

  auto state = LoadLatestState(Folder(), &warnings);

  ASSERT_THAT(state, IsOk());
  EXPECT_EQ(state->counters.iteration(), 1);
  EXPECT_THAT(warnings, ElementsAre(HasSubstr("expected SHA-256")));
}

TEST(StateFiles, PassOverAStateWhoseWritingWasCutShort) {
  ASSERT_THAT(SaveState(Folder(), MakeState(1), 3), IsOk());
  const std::string cut = JoinPath(Folder(), "state-00000002");
  ASSERT_THAT(MakeDirectories(cut), IsOk());
  ASSERT_THAT(WriteFileAtomically(JoinPath(cut, "state.pb"), "half"), IsOk());
  std::vector<std::string> warnings;

  auto state = LoadLatestState(Folder(), &warnings);

  ASSERT_THAT(state, IsOk());
  EXPECT_EQ(state->counters.iteration(), 1);
}

TEST(StateFiles, SayWhenThereIsNone) {
  std::vector<std::string> warnings;

  EXPECT_THAT(LoadLatestState(Folder(), &warnings),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr(Folder())));
}

}  // namespace
}  // namespace sinew::learner
