// The C interface, used from a C program.
#include "deploy/runtime/sinew_runtime.h"

#include <cmath>
#include <string>

#include "common/files.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "deploy/runtime/c_program.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::runtime {
namespace {

using ::sinew::testing::IsOk;
using ::testing::HasSubstr;

struct Paths {
  Paths() {
    const world::testing::ToyWorld toy = world::testing::MakeToyWorld();
    bundle = JoinPath(toy.folder, "bundle");
    library = JoinPath(toy.folder, "library");
    EXPECT_THAT(bundle::WriteBundle(bundle::testing::ToyContent(toy), bundle),
                IsOk());
  }
  std::string bundle, library;
};

TEST(CInterface, RunsFromC) {
  const Paths paths;
  double target = NAN;
  char error[200] = "";

  EXPECT_EQ(RunInC(paths.bundle.c_str(), paths.library.c_str(), "turn", &target,
                   error, sizeof error),
            0)
      << error;

  // The reference swings by 0.3 rad; the policy adds 0.2 rad per unit.
  EXPECT_LT(std::abs(target), 2.5);
  EXPECT_NE(target, 0);
}

TEST(CInterface, GivesErrorsAsText) {
  const Paths paths;
  double target = 0;
  char error[200] = "";

  EXPECT_EQ(RunInC("/nowhere", "", "", &target, error, sizeof error), -1);
  EXPECT_THAT(error, HasSubstr("/nowhere: expected a bundle"));
  EXPECT_EQ(RunInC(paths.bundle.c_str(), paths.library.c_str(), "swim", &target,
                   error, sizeof error),
            -1);
  EXPECT_THAT(error, HasSubstr("found \"swim\""));
  EXPECT_EQ(RunInC("/nowhere", "", "", &target, error, 9), -1);
  EXPECT_STREQ(error, "/nowhere");
}

TEST(CInterface, DescribesThePolicy) {
  const Paths paths;
  sinew_runtime* policy = sinew_open(paths.bundle.c_str(), nullptr, 0);
  ASSERT_NE(policy, nullptr);
  double stiffness[4], limit[4];
  sinew_gains(policy, stiffness, nullptr, limit);

  EXPECT_EQ(sinew_joint_count(policy), 4);
  EXPECT_STREQ(sinew_joint_name(policy, 2), "hip_fr");
  EXPECT_EQ(sinew_joint_name(policy, 4), nullptr);
  EXPECT_EQ(stiffness[2], 100);
  EXPECT_EQ(limit[0], 60);
  EXPECT_EQ(sinew_control_hz(policy), 30);
  EXPECT_EQ(sinew_frame_count(policy), 1);
  EXPECT_EQ(sinew_frame_ahead(policy, 0), 1);
  EXPECT_EQ(sinew_foot_count(policy), 2);
  EXPECT_EQ(sinew_needs_torque(policy), 0);
  EXPECT_EQ(sinew_clip_count(policy), 0);
  EXPECT_STREQ(sinew_error(policy), "");
  EXPECT_EQ(sinew_step(policy, nullptr, limit), -1);
  EXPECT_STREQ(sinew_error(policy), "state: expected a pointer, found NULL");
  sinew_close(policy);
}

}  // namespace
}  // namespace sinew::runtime
