#ifndef SINEW_LEARNER_PROCEDURE_TESTING_PROCEDURE_HISTORY_H_
#define SINEW_LEARNER_PROCEDURE_TESTING_PROCEDURE_HISTORY_H_

#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "learner/procedure/procedure.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew::learner {

// What tests of decisions share: a procedure over four clips whose stages end
// as the test says.

using Clips = std::vector<std::string>;

inline const Clips kClips = {"a", "b", "c", "d"};

inline v1::Procedure MakeProcedure() {
  v1::Procedure procedure;
  procedure.set_max_primitives(2);
  procedure.set_learnable_share(0.5);
  procedure.set_full_samples(1000);
  procedure.set_hard_samples(500);
  procedure.set_recovery_samples(300);
  procedure.set_composer_samples(200);
  return procedure;
}

// A procedure so far.
struct History {
  v1::Procedure procedure = MakeProcedure();
  std::vector<FinishedStage> finished;

  Decision Next() const { return NextStage(procedure, kClips, finished); }

  // The next stage ends, and its weights fail these clips.
  void Finish(const Clips& failed, bool plateau = true) {
    const Decision decision = Next();
    ASSERT_TRUE(decision.next.has_value()) << decision.reason;
    finished.push_back({.stage = *decision.next,
                        .plateau = plateau,
                        .iterations = 10,
                        .samples = 640,
                        .train_seconds = 1,
                        .failed = failed});
  }
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_PROCEDURE_TESTING_PROCEDURE_HISTORY_H_
