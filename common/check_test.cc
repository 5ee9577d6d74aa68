#include "common/check.h"

#include "gtest/gtest.h"

namespace sinew {
namespace {

int Count(int& calls) { return ++calls; }

TEST(Check, DoesNothingWhenTheConditionHolds) {
  int messages = 0;

  SINEW_CHECK(1 + 1 == 2) << Count(messages);

  EXPECT_EQ(messages, 0);
}

TEST(CheckDeathTest, PrintsPlaceConditionAndMessageThenAborts) {
  const int rows = -3;

  EXPECT_DEATH(SINEW_CHECK(rows > 0) << "rows " << rows,
               "check_test.cc:[0-9]+: check failed: rows > 0: rows -3");
}

TEST(Check, BindsToItsOwnIfNotToTheCallersElse) {
  bool reached_else = false;

  if (true) {
    SINEW_CHECK(true);
  } else {
    reached_else = true;
  }

  EXPECT_FALSE(reached_else);
}

#ifdef NDEBUG
TEST(DebugCheck, IsNotEvaluatedInOptimisedBuilds) {
  int calls = 0;

  SINEW_DCHECK(Count(calls) == 7);

  EXPECT_EQ(calls, 0);
}
#else
TEST(DebugCheckDeathTest, AbortsInDebugBuilds) {
  int calls = 0;

  EXPECT_DEATH(SINEW_DCHECK(Count(calls) == 7) << "seven", "seven");
}
#endif

}  // namespace
}  // namespace sinew
