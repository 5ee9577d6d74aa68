// Counts what a tick takes from the heap: a program of its own, since it
// replaces operator new.
#include <string>
#include <vector>

#include "common/files.h"
#include "common/testing/allocation_count.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "deploy/bundle/testing/toy_latent.h"
#include "deploy/runtime/pose.h"
#include "deploy/runtime/runtime.h"
#include "deploy/runtime/simulation.h"
#include "gtest/gtest.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::runtime {
namespace {

using ::sinew::testing::IsOk;

TEST(RuntimeAllocation, NeitherResetNorStepTouchTheHeap) {
  v1::Recipe recipe = world::testing::ToyRecipe();
  v1::Observation& observation = *recipe.mutable_task()->mutable_observation();
  observation.clear_blocks();
  for (int block = 1; block <= 5; ++block) {
    observation.add_blocks(static_cast<v1::Observation::Block>(block));
  }
  observation.add_blocks(v1::Observation::BLOCK_SELF_BODIES);
  const world::testing::ToyWorld toy = world::testing::MakeToyWorld(recipe);
  const std::string directory = JoinPath(toy.folder, "bundle");
  ASSERT_THAT(bundle::WriteBundle(bundle::testing::ToyContent(toy), directory),
              IsOk());
  auto policy = *Runtime::Open(directory);
  ASSERT_THAT(policy->LoadLibrary(JoinPath(toy.folder, "library")), IsOk());
  ASSERT_THAT(policy->Play("turn", 0, Runtime::Align::kToBody), IsOk());
  Simulation body(*policy);
  ASSERT_THAT(body.Start(*policy), IsOk());
  Pose imu = body.pose();
  imu.root_position = nullptr;
  imu.root_linear_velocity = nullptr;
  PoseBuffer frame(4);
  const double contact[2] = {1, 0};
  ASSERT_THAT(policy->PlayNearest(imu, Runtime::Among::kAll, 3), IsOk());
  const int64_t before = sinew::testing::AllocationCount();
  ASSERT_GT(before, 0);

  bool ok = policy->Reset(body.pose(), nullptr).ok();
  for (int step = 0; step < 60; ++step) {
    ok = ok && policy->Step(body.pose(), body.target()).ok();
    ok = ok && body.Step().ok();
    ok = ok && policy->Step(imu, body.target()).ok();
    ok = ok && policy->ReadReference(1, &frame).ok();
    Pose given = frame.pose();
    given.contact = contact;
    ok = ok && policy->StepTo(body.pose(), {&given, 1}, body.target()).ok();
    ok = ok && policy->PlayNearest(imu, Runtime::Among::kAll, 3).ok();
  }
  const int64_t after = sinew::testing::AllocationCount();

  EXPECT_TRUE(ok);
  EXPECT_EQ(after - before, 0);
}

TEST(RuntimeAllocation, NorDoesWhatIsDoneWithALatent) {
  const world::testing::ToyWorld toy =
      world::testing::MakeToyWorld(bundle::testing::ToyLatentRecipe());
  auto policy = *Runtime::Open(bundle::testing::WriteToyLatent(toy));
  ASSERT_THAT(policy->LoadLibrary(toy.library_folder), IsOk());
  ASSERT_THAT(policy->Play("turn", 0, Runtime::Align::kToBody), IsOk());
  Simulation body(*policy);
  ASSERT_THAT(body.Start(*policy), IsOk());
  std::vector<double> mean(6), spread(6);
  std::vector<float> own(33);
  const int64_t before = sinew::testing::AllocationCount();

  bool ok = true;
  for (int step = 0; step < 20; ++step) {
    const Pose& pose = body.pose();
    ok = ok && policy->SelfObservation(pose, absl::MakeSpan(own)).ok();
    ok =
        ok &&
        policy->Encode(pose, absl::MakeSpan(mean), absl::MakeSpan(spread)).ok();
    ok = ok && policy->Decode(pose, mean, body.target()).ok();
    ok = ok &&
         policy->Prior(pose, absl::MakeSpan(mean), absl::MakeSpan(spread)).ok();
    ok = ok && policy->Sample(pose, mean, body.target()).ok();
    ok = ok && body.Step().ok();
  }
  const int64_t after = sinew::testing::AllocationCount();

  EXPECT_TRUE(ok);
  EXPECT_EQ(after - before, 0);
}

}  // namespace
}  // namespace sinew::runtime
