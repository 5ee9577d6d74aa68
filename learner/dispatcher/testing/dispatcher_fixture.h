#ifndef SINEW_LEARNER_DISPATCHER_TESTING_DISPATCHER_FIXTURE_H_
#define SINEW_LEARNER_DISPATCHER_TESTING_DISPATCHER_FIXTURE_H_

#include "absl/time/time.h"
#include "common/testing/simulated_clock.h"
#include "gtest/gtest.h"
#include "learner/dispatcher/dispatcher.h"
#include "learner/dispatcher/testing/dispatcher_rig.h"

namespace sinew::learner {

// A rig whose clock the test moves. Heartbeat 10 s: silent for more than 30 s
// is lost; late at 20 s.
class DispatcherFixture : public ::testing::Test {
 protected:
  // Once the ticker waits: it then sees the new time.
  void Advance(absl::Duration duration) {
    ASSERT_TRUE(clock_.AwaitWaiters(1));
    clock_.Advance(duration);
  }

  sinew::testing::SimulatedClock clock_;
  DispatcherRig rig_{clock_};
  Dispatcher& dispatcher_ = rig_.dispatcher();
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_DISPATCHER_TESTING_DISPATCHER_FIXTURE_H_
