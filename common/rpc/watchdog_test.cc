#include "common/rpc/watchdog.h"

#include <future>

#include "absl/time/time.h"
#include "gtest/gtest.h"

namespace sinew::rpc {
namespace {

TEST(Watchdog, BarksWhenNobodyFeedsIt) {
  std::promise<void> barked;
  Watchdog dog(absl::Milliseconds(1), [&barked] { barked.set_value(); });

  barked.get_future().wait();

  EXPECT_TRUE(dog.has_expired());
}

TEST(Watchdog, EndsAtOnceWithoutBarking) {
  bool barked = false;
  {
    Watchdog dog(absl::Hours(1), [&barked] { barked = true; });
    dog.Feed();
    EXPECT_FALSE(dog.has_expired());
  }
  EXPECT_FALSE(barked);
}

}  // namespace
}  // namespace sinew::rpc
