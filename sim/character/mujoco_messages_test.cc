#include "sim/character/mujoco_messages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <string>
#include <vector>

namespace sinew::character {
namespace {

using ::testing::ElementsAre;

// What the program's own handler got.
std::vector<std::string>& Received() {
  static auto* received = new std::vector<std::string>();
  return *received;
}

// One test: the first collector of a process is the one that replaces.
TEST(WarningCollector, CollectsItsOwnAndLeavesTheRestToTheProgram) {
  mju_user_warning = [](const char* message) {
    Received().emplace_back(message);
  };
  {
    const WarningCollector outer;
    mju_warning("first");
    {
      const WarningCollector inner;
      mju_warning("second");
      EXPECT_EQ(inner.text(), "second");
    }
    mju_warning("third");
    EXPECT_EQ(outer.text(), "first\nthird");
  }
  EXPECT_THAT(Received(), ElementsAre());

  mju_warning("fourth");

  EXPECT_THAT(Received(), ElementsAre("fourth"));
}

}  // namespace
}  // namespace sinew::character
