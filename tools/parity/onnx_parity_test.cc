// The executor against onnxruntime, on every operation and on whole policies.
#include <cstdlib>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/files.h"
#include "common/policy/executor.h"
#include "common/policy/onnx/onnx_writer.h"
#include "common/policy/testing/examples.h"
#include "common/policy/testing/reference.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tools/parity/onnx_runtime.h"

namespace sinew::tools {
namespace {

using ::sinew::policy::testing::AllExamples;
using ::sinew::policy::testing::Example;
using ::sinew::policy::testing::ExampleInputs;
using ::sinew::policy::testing::PolicyExamples;
using ::sinew::policy::testing::RelativeDifference;
using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr int kBatch = 5;

using Inputs = std::map<std::string, std::vector<float>>;

// A fresh folder of this test's own.
std::string Folder(const std::string& name) {
  const std::string folder =
      JoinPath(std::getenv("TEST_TMPDIR"), absl::StrCat(name));
  EXPECT_THAT(MakeDirectories(folder), IsOk());
  return folder;
}

OnnxRuntimeOptions Options(const std::string& scratch) {
  const std::string runfiles = std::getenv("TEST_SRCDIR");
  return {.script = JoinPath(runfiles, "sinew/tools/parity/onnx_check.py"),
          .packages = JoinPath(runfiles, "onnx_python"),
          .scratch = Folder(scratch)};
}

// Writes model and weights; returns the model's path.
std::string WriteModel(const Example& example) {
  const std::string folder = Folder(example.name);
  const std::string weights = SerializeSafetensors(example.weights);
  const auto model = policy::WriteOnnx(example.graph, example.graph_name,
                                       *LocateSafetensors(weights, "weights"),
                                       "weights.safetensors");
  EXPECT_THAT(model, IsOk());
  const std::string path = JoinPath(folder, "model.onnx");
  EXPECT_THAT(WriteFileAtomically(path, *model), IsOk());
  EXPECT_THAT(
      WriteFileAtomically(JoinPath(folder, "weights.safetensors"), weights),
      IsOk());
  return path;
}

TensorMap AsTensors(const Inputs& inputs) {
  TensorMap tensors;
  for (const auto& [name, values] : inputs) {
    const int64_t width = static_cast<int64_t>(values.size()) / kBatch;
    tensors[name] = HostTensor::Float32({kBatch, width}, values);
  }
  return tensors;
}

// The example's executor after running the inputs.
std::unique_ptr<policy::Executor> RunHere(const Example& example,
                                          const Inputs& inputs) {
  auto executor = *policy::Executor::Create(
      *policy::PackWeights(example.graph, example.graph_name, example.weights),
      kBatch);
  for (const auto& [name, values] : inputs) {
    std::copy(values.begin(), values.end(),
              executor->input(executor->input_index(name)).begin());
  }
  executor->Run(kBatch);
  return executor;
}

TEST(OnnxParity, HoldsForEveryOperationAndWholePolicies) {
  const std::vector<Example> examples = AllExamples();
  std::vector<OnnxJob> jobs;
  for (const Example& example : examples) {
    jobs.push_back(
        {.model = WriteModel(example),
         .inputs = AsTensors(ExampleInputs(example, kBatch, /*seed=*/3))});
  }

  const auto results = RunOnnx(Options("parity"), jobs);

  ASSERT_THAT(results, IsOk());
  for (size_t i = 0; i < examples.size(); ++i) {
    const auto executor =
        RunHere(examples[i], ExampleInputs(examples[i], kBatch, /*seed=*/3));
    EXPECT_FALSE((*results)[i].empty()) << examples[i].name;
    for (const auto& [tap, values] : (*results)[i]) {
      EXPECT_LT(RelativeDifference(executor->tap(executor->tap_index(tap)),
                                   values.float32()),
                1e-5)
          << examples[i].name << " " << tap;
    }
  }
}

TEST(OnnxParity, NoticesWeightsThatDiffer) {
  const Example example = PolicyExamples()[0];
  const Inputs inputs = ExampleInputs(example, kBatch, /*seed=*/3);
  Example other = example;
  other.weights.at("policy/mean/bias").mutable_float32()[0] += 1e-3f;

  const auto results =
      RunOnnx(Options("differ"),
              {{.model = WriteModel(example), .inputs = AsTensors(inputs)}});

  ASSERT_THAT(results, IsOk());
  const auto executor = RunHere(other, inputs);
  EXPECT_GT(RelativeDifference(executor->tap(executor->tap_index("mean")),
                               results->at(0).at("mean").float32()),
            1e-5);
}

TEST(OnnxParity, NamesTheModelThatTheCheckerRefuses) {
  const std::string path = JoinPath(Folder("broken"), "broken.onnx");
  ASSERT_THAT(WriteFileAtomically(path, "no model"), IsOk());

  EXPECT_THAT(RunOnnx(Options("refused"), {{.model = path, .inputs = {}}}),
              StatusIs(absl::StatusCode::kInternal,
                       AllOf(HasSubstr("exit code 1"),
                             HasSubstr(absl::StrCat("onnx_check: ", path)))));
}

TEST(OnnxParity, NoticesAMissingWeightsFile) {
  const Example example = AllExamples()[0];
  const std::string whole = WriteModel(example);
  const std::string path = JoinPath(Folder("alone"), "model.onnx");
  ASSERT_THAT(WriteFileAtomically(path, *ReadFile(whole)), IsOk());

  EXPECT_THAT(
      RunOnnx(Options("missing"),
              {{.model = path,
                .inputs = AsTensors(ExampleInputs(example, kBatch, 3))}}),
      StatusIs(absl::StatusCode::kInternal, HasSubstr("weights.safetensors")));
}

TEST(OnnxParity, SaysWhichPythonIsMissing) {
  OnnxRuntimeOptions options = Options("python");
  options.python = "/nowhere/python";

  EXPECT_THAT(
      RunOnnx(options, {{.model = "m", .inputs = {}}}),
      StatusIs(absl::StatusCode::kNotFound, HasSubstr("/nowhere/python")));
}

}  // namespace
}  // namespace sinew::tools
