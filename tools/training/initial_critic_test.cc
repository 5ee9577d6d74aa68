// The value network that comes with a bundle, read from its run's states.

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "common/clock.h"
#include "common/files.h"
#include "common/policy/safetensors.h"
#include "common/rpc/credentials.h"
#include "common/testing/matchers.h"
#include "deploy/checkpoint/client/artifact_store.h"
#include "deploy/checkpoint/open_store.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "learner/state/state_store.h"
#include "learner/state/testing/make_state.h"
#include "learner/trainer/trainer.h"
#include "tools/training/initial_policy.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;

// A run's folder of checkpoints with these states.
std::string WriteStates(const std::string& name,
                        const std::vector<learner::Trainer::State>& states) {
  const std::string folder = JoinPath(::testing::TempDir(), name);
  const SystemClock clock;
  const auto store = checkpoint::OpenStore(
      folder, checkpoint::StoreAccess::kWrite, rpc::Security(), clock);
  EXPECT_THAT(store, IsOk());
  for (const learner::Trainer::State& state : states) {
    EXPECT_THAT(learner::SaveState(**store, state, /*keep=*/3), IsOk());
  }
  return folder;
}

learner::Trainer::State StateWithCritic(int64_t iteration) {
  learner::Trainer::State state = learner::MakeState(iteration);
  state.tensors["critic/value/bias"] =
      HostTensor::Float32({1}, {static_cast<float>(iteration)});
  return state;
}

TEST(ReadCritic, GivesTheValueNetworkOfTheNewestStateAndNothingElse) {
  const std::string folder =
      WriteStates("two", {StateWithCritic(20), StateWithCritic(40)});

  const auto critic = ReadCritic(folder, 40, SystemClock());

  ASSERT_THAT(critic, IsOk());
  ASSERT_EQ(critic->size(), 1u);
  EXPECT_EQ(critic->at("critic/value/bias").float32()[0], 40);
}

TEST(ReadCritic, RefusesAStateOfAnotherIterationAndOneWithoutCritic) {
  const std::string one = WriteStates("one", {StateWithCritic(20)});
  const std::string none = WriteStates("none", {learner::MakeState(20)});

  EXPECT_THAT(ReadCritic(one, 40, SystemClock()),
              StatusIs(absl::StatusCode::kDataLoss,
                       AllOf(HasSubstr(one), HasSubstr("iteration 40"),
                             HasSubstr("found one of iteration 20"))));
  EXPECT_THAT(ReadCritic(none, 20, SystemClock()),
              StatusIs(absl::StatusCode::kDataLoss,
                       AllOf(HasSubstr(none), HasSubstr("critic/"))));
}

}  // namespace
}  // namespace sinew::tools
