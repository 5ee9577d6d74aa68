// The examples run on a bundle with a latent: the program in MuJoCo, and the
// Python script, which must give the executor's actions.
#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/files.h"
#include "common/policy/executor.h"
#include "common/random/philox.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "deploy/bundle/testing/toy_latent.h"
#include "deploy/runtime/testing/run_program.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::runtime {
namespace {

using ::sinew::testing::IsOk;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using testing::Outcome;
using testing::Runfile;
using testing::RunProgram;

constexpr int kRows = 5, kSelf = 33, kWidth = 6;

// A bundle with a latent on disk.
struct LatentFolder {
  LatentFolder()
      : toy(world::testing::MakeToyWorld(bundle::testing::ToyLatentRecipe())),
        content(bundle::testing::ToyLatentContent(toy)),
        bundle(JoinPath(toy.folder, "bundle")) {
    EXPECT_THAT(bundle::WriteBundle(content, bundle), IsOk());
  }
  world::testing::ToyWorld toy;
  bundle::BundleContent content;
  std::string bundle;
};

std::vector<float> Normal(int width, uint64_t seed) {
  std::vector<float> values(static_cast<size_t>(kRows) * width);
  FillNormal({.seed = seed}, absl::MakeSpan(values));
  return values;
}

// A file with `values` as text, a row a line; its path.
std::string WriteRows(const std::string& folder, const std::string& name,
                      const std::vector<float>& values) {
  std::string text;
  const size_t width = values.size() / kRows;
  for (size_t i = 0; i < values.size(); ++i) {
    absl::StrAppend(&text, values[i], (i + 1) % width == 0 ? "\n" : " ");
  }
  const std::string path = JoinPath(folder, name);
  EXPECT_THAT(WriteFileAtomically(path, text), IsOk());
  return path;
}

// sample_with_onnx.py; its inputs go into `folder`.
Outcome RunScript(const std::string& bundle, const std::string& folder,
                  const std::vector<float>& states,
                  const std::vector<float>& noise, const std::string& actions) {
  return RunProgram(
      {"python3.11",
       Runfile("sinew/deploy/runtime/examples/sample_with_onnx.py"), bundle,
       WriteRows(folder, "states.txt", states),
       WriteRows(folder, "noise.txt", noise), actions});
}

std::vector<double> ParseNumbers(const std::string& text) {
  std::istringstream stream(text);
  std::vector<double> numbers;
  for (double number; stream >> number;) numbers.push_back(number);
  return numbers;
}

// The graph "sample" by the executor.
std::vector<float> SampleHere(const bundle::BundleContent& content,
                              const std::vector<float>& states,
                              const std::vector<float>& noise) {
  const auto executor = *policy::Executor::Create(
      *policy::PackWeights(content.graph, "sample", content.weights), kRows);
  const auto set = [&](const char* name, const std::vector<float>& values) {
    std::copy(values.begin(), values.end(),
              executor->input(executor->input_index(name)).begin());
  };
  set("self_observation", states);
  set("noise", noise);
  executor->Run(kRows);
  const auto action = executor->tap(executor->tap_index("action"));
  return {action.begin(), action.end()};
}

TEST(SampleWithOnnx, GivesTheActionsOfTheExecutor) {
  const LatentFolder folder;
  const std::vector<float> states = Normal(kSelf, 1), noise = Normal(kWidth, 2);

  const std::string written = JoinPath(folder.toy.folder, "actions.txt");

  const Outcome outcome =
      RunScript(folder.bundle, folder.toy.folder, states, noise, written);

  ASSERT_EQ(outcome.code, 0) << outcome.output;
  const std::vector<double> actions = ParseNumbers(*ReadFile(written));
  const std::vector<float> expected = SampleHere(folder.content, states, noise);
  ASSERT_EQ(actions.size(), expected.size());
  for (size_t i = 0; i < expected.size(); ++i) {
    // States have passed through text of six digits.
    EXPECT_NEAR(actions[i], expected[i], 1e-4) << i;
  }
}

TEST(SampleWithOnnx, NamesTheModelThatABundleLacks) {
  const world::testing::ToyWorld toy = world::testing::MakeToyWorld();
  const std::string bundle = JoinPath(toy.folder, "bundle");
  ASSERT_THAT(bundle::WriteBundle(bundle::testing::ToyContent(toy), bundle),
              IsOk());

  const Outcome outcome =
      RunScript(bundle, toy.folder, Normal(kSelf, 1), Normal(kWidth, 2),
                JoinPath(toy.folder, "actions.txt"));

  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.output, HasSubstr("prior.onnx"));
}

TEST(SampleWithOnnx, RefusesAFileThatWasEdited) {
  for (const char* name : {"prior.onnx", "weights.safetensors"}) {
    const LatentFolder folder;
    const std::string path = JoinPath(folder.bundle, name);
    std::string content = *ReadFile(path);
    content.back() ^= 1;
    ASSERT_THAT(WriteFileAtomically(path, content), IsOk());
    const std::string written = JoinPath(folder.toy.folder, "actions.txt");

    const Outcome outcome =
        RunScript(folder.bundle, folder.toy.folder, Normal(kSelf, 1),
                  Normal(kWidth, 2), written);

    EXPECT_EQ(outcome.code, 1);
    EXPECT_THAT(outcome.output,
                HasSubstr(absl::StrCat(path, ": SHA-256: expected")));
    EXPECT_FALSE(FileExists(written));
  }
}

TEST(Sample, MovesTheBodyByThePriorAndSaysWhereItsRootIs) {
  const LatentFolder folder;

  const Outcome outcome =
      RunProgram({Runfile("sinew/deploy/runtime/examples/sample"),
                  folder.bundle, folder.toy.library_folder, "0.5"});

  EXPECT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_THAT(outcome.output,
              ContainsRegex("0.5 s by the prior, 6 numbers a step, root at "
                            "-?[0-9.]+ m"));
}

TEST(Sample, SaysThatABundleHasNoLatent) {
  const world::testing::ToyWorld toy = world::testing::MakeToyWorld();
  const std::string bundle = JoinPath(toy.folder, "bundle");
  ASSERT_THAT(bundle::WriteBundle(bundle::testing::ToyContent(toy), bundle),
              IsOk());

  const Outcome outcome =
      RunProgram({Runfile("sinew/deploy/runtime/examples/sample"), bundle,
                  toy.library_folder});

  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.output, HasSubstr("this bundle has no latent"));
}

}  // namespace
}  // namespace sinew::runtime
