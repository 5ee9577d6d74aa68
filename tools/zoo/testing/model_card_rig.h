#ifndef SINEW_TOOLS_ZOO_TESTING_MODEL_CARD_RIG_H_
#define SINEW_TOOLS_ZOO_TESTING_MODEL_CARD_RIG_H_

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "absl/status/statusor.h"
#include "common/clock.h"
#include "common/files.h"
#include "common/stop.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "sim/world/testing/toy_world.h"
#include "tools/evaluation/evaluate_bundle.h"
#include "tools/zoo/card_facts.h"
#include "tools/zoo/model_card.h"

namespace sinew::zoo {

// A bundle of the toy world in a folder as zoo/ has them.
class ModelCardRig : public ::testing::Test {
 protected:
  ModelCardRig() : toy_(world::testing::MakeToyWorld()) {
    EXPECT_THAT(MakeDirectories(Path("entry")), sinew::testing::IsOk());
    options_.bundle = Path("entry/bundle");
    options_.motions = toy_.library_folder;
    EXPECT_THAT(
        bundle::WriteBundle(bundle::testing::ToyContent(toy_), options_.bundle),
        sinew::testing::IsOk());
  }

  std::string Path(const std::string& name) const {
    return JoinPath(toy_.folder, name);
  }
  void Evaluate() {
    options_.eval = Path("eval.json");
    EXPECT_THAT(evaluation::EvaluateBundle(
                    options_.bundle, options_.motions, options_.eval,
                    {.starts = 1, .seconds = 0.5}, StopToken())
                    .status(),
                sinew::testing::IsOk());
  }
  // Puts a field, with the comma after it, before those that are there.
  void AddToEvaluation(const std::string& field) {
    std::string text = *ReadFile(options_.eval);
    text.insert(text.find('{') + 1, field);
    EXPECT_THAT(WriteFileAtomically(options_.eval, text),
                sinew::testing::IsOk());
  }
  absl::StatusOr<std::string> Card() const {
    const auto facts = ReadCardFacts(options_, clock_);
    if (!facts.ok()) return facts.status();
    return ModelCard(*facts);
  }

  const SystemClock clock_;
  const world::testing::ToyWorld toy_;
  CardOptions options_;
};

}  // namespace sinew::zoo

#endif  // SINEW_TOOLS_ZOO_TESTING_MODEL_CARD_RIG_H_
