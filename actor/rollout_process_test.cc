// That a rollout is a function of its inputs' bytes: whatever process, and
// however many threads beside it.
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "actor/rollout.h"
#include "actor/testing/rollout_rig.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/segment/segment_layout.h"
#include "common/subprocess.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::actor {
namespace {

using ::sinew::testing::IsOk;
using testing::Bytes;
using testing::RolloutRig;

constexpr char kProgram[] = "actor/testing/rollout_process";

// The segments that `threads` threads of another process give.
std::vector<std::string> RunElsewhere(const RolloutRig& rig,
                                      const v1::Order& order, int threads) {
  std::string folder = JoinPath(::testing::TempDir(), "process.XXXXXX");
  EXPECT_NE(mkdtemp(folder.data()), nullptr);
  std::map<std::string, std::string> files = rig.asset_bytes;
  files["order"] = SerializeDeterministically(order);
  files["snapshot"] = SerializeDeterministically(rig.message);
  for (const auto& [name, bytes] : files) {
    EXPECT_THAT(WriteFileAtomically(JoinPath(folder, name), bytes), IsOk());
  }
  const auto child =
      Subprocess::Start({.argv = {kProgram, folder, absl::StrCat(threads)}});
  EXPECT_THAT(child, IsOk());
  const auto status = (*child)->Wait(absl::Minutes(2));
  EXPECT_THAT(status, IsOk());
  EXPECT_TRUE(status->ok()) << status->ToString();
  std::vector<std::string> segments;
  for (int i = 0; i < threads; ++i) {
    const auto bytes = ReadFile(JoinPath(folder, absl::StrCat("segment-", i)));
    EXPECT_THAT(bytes, IsOk());
    segments.push_back(*bytes);
  }
  return segments;
}

TEST(RolloutInAnotherProcess, GivesTheSameBytesOnAnyNumberOfThreads) {
  RolloutRig rig;
  const v1::Order order = rig.TrainOrder(/*environments=*/3, /*horizon=*/40);
  const std::string here = Bytes(rig.Run(order));

  for (int threads : {1, 2, 5}) {
    for (const std::string& there : RunElsewhere(rig, order, threads)) {
      // Not EXPECT_EQ, which would print them.
      EXPECT_TRUE(there == here) << threads << " threads";
    }
  }
}

TEST(RolloutInAnotherProcess, ContinuesAtACutAsIfThereWereNone) {
  RolloutRig rig;
  const v1::Segment whole = rig.Run(rig.TrainOrder(3, 60));
  v1::Order half = rig.TrainOrder(3, 30);
  *half.mutable_states() = rig.Run(half).end_states();

  v1::Segment second;
  ASSERT_TRUE(second.ParseFromString(RunElsewhere(rig, half, 1)[0]));

  for (int e = 0; e < 3; ++e) {
    EXPECT_EQ(SerializeDeterministically(whole.end_states(e)),
              SerializeDeterministically(second.end_states(e)));
  }
  EXPECT_EQ(FindColumn(whole, column::kBoundaryObservation)->data(),
            FindColumn(second, column::kBoundaryObservation)->data());
}

TEST(RolloutInAnotherProcess, EvaluatesToTheSameBytes) {
  RolloutRig rig;
  const v1::Order order = rig.EvaluationOrder({{1, 0, 19}, {2, 0, 15}});
  const std::string here = Bytes(rig.Run(order));

  for (const std::string& there : RunElsewhere(rig, order, 2)) {
    EXPECT_TRUE(there == here);
  }
}

}  // namespace
}  // namespace sinew::actor
