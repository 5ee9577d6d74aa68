// The three back ends of a policy graph on every operation and on whole
// policies: executor, libtorch and onnxruntime against each other and against
// the formulas in double.
#include <cstdlib>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "common/files.h"
#include "common/policy/executor.h"
#include "common/policy/onnx/onnx_writer.h"
#include "common/policy/testing/examples.h"
#include "common/policy/testing/reference.h"
#include "common/policy/validate.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "learner/torch/torch_runner.h"
#include "tools/parity/onnx_runtime.h"

namespace sinew::tools {
namespace {

using ::sinew::learner::TorchRunner;
using ::sinew::policy::testing::AllExamples;
using ::sinew::policy::testing::Example;
using ::sinew::policy::testing::ExampleInputs;
using ::sinew::policy::testing::PolicyExamples;
using ::sinew::policy::testing::ReferenceValues;
using ::sinew::policy::testing::RelativeDifference;
using ::sinew::policy::testing::RunReference;
using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;

// What is asked of every two back ends, relative to a tap's largest value.
constexpr double kTolerance = 1e-5;
constexpr int kBatch = 5;

using Inputs = std::map<std::string, std::vector<float>>;

// A fresh folder of this test's own.
std::string Folder(const std::string& name) {
  const std::string folder = JoinPath(std::getenv("TEST_TMPDIR"), name);
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

Inputs InputsOf(const Example& example) {
  return ExampleInputs(example, kBatch, /*seed=*/3);
}

// Runs every example through onnxruntime, once for all tests: a Python process
// takes seconds to start.
class BackEndsOn : public ::testing::TestWithParam<size_t> {
 public:
  static void SetUpTestSuite() {
    std::vector<OnnxJob> jobs;
    for (const Example& example : Examples()) {
      jobs.push_back({.model = WriteModel(example),
                      .inputs = AsTensors(InputsOf(example))});
    }
    onnx_ = new absl::StatusOr<std::vector<TensorMap>>(
        RunOnnx(Options("parity"), jobs));
  }
  static void TearDownTestSuite() { delete onnx_; }

  static const std::vector<Example>& Examples() {
    static const auto* const examples = new std::vector<Example>(AllExamples());
    return *examples;
  }

 protected:
  const Example& example() const { return Examples()[GetParam()]; }
  const v1::Graph& graph() const {
    return **policy::FindGraph(example().graph, example().graph_name);
  }
  std::vector<float> Onnx(const std::string& tap) const {
    const auto values = (**onnx_)[GetParam()].at(tap).float32();
    return std::vector<float>(values.begin(), values.end());
  }
  TorchRunner::Rows Torch() const {
    const auto runner = TorchRunner::Create(
        example().graph, example().graph_name, example().weights, {});
    EXPECT_THAT(runner, IsOk());
    const auto rows = (*runner)->Run(kBatch, InputsOf(example()));
    EXPECT_THAT(rows, IsOk());
    return *rows;
  }
  ReferenceValues Exact() const {
    ReferenceValues inputs;
    for (const auto& [name, values] : InputsOf(example())) {
      inputs[name].assign(values.begin(), values.end());
    }
    return RunReference(example().graph, example().graph_name,
                        example().weights, inputs, kBatch);
  }

  static absl::StatusOr<std::vector<TensorMap>>* onnx_;
};

absl::StatusOr<std::vector<TensorMap>>* BackEndsOn::onnx_ = nullptr;

INSTANTIATE_TEST_SUITE_P(
    Examples, BackEndsOn,
    ::testing::Range<size_t>(0, BackEndsOn::Examples().size()),
    [](const auto& info) { return BackEndsOn::Examples()[info.param].name; });

TEST_P(BackEndsOn, AgreeWithEachOtherAndWithTheFormulas) {
  ASSERT_THAT(*onnx_, IsOk());
  const auto executor = RunHere(example(), InputsOf(example()));
  const TorchRunner::Rows torch = Torch();
  const ReferenceValues exact = Exact();

  ASSERT_GT(graph().taps_size(), 0);
  for (const v1::Tap& tap : graph().taps()) {
    const auto own = executor->tap(executor->tap_index(tap.name()));
    const std::vector<float>& trained = torch.at(tap.name());
    const std::vector<float> exported = Onnx(tap.name());

    EXPECT_LT(RelativeDifference(own, trained), kTolerance) << tap.name();
    EXPECT_LT(RelativeDifference(own, exported), kTolerance) << tap.name();
    EXPECT_LT(RelativeDifference(trained, exported), kTolerance) << tap.name();
    EXPECT_LT(RelativeDifference(trained, exact.at(tap.name())), kTolerance)
        << tap.name();
    EXPECT_LT(RelativeDifference(exported, exact.at(tap.name())), kTolerance)
        << tap.name();
  }
}

TEST(BackEnds, AreComparedOnEveryOperation) {
  std::set<int> seen;
  for (const Example& example : BackEndsOn::Examples()) {
    for (const v1::Graph& graph : example.graph.graphs()) {
      for (const v1::Node& node : graph.nodes()) seen.insert(node.op());
    }
  }

  for (int op = v1::Op_MIN + 1; op <= v1::Op_MAX; ++op) {
    EXPECT_TRUE(seen.contains(op)) << v1::Op_Name(static_cast<v1::Op>(op));
  }
}

TEST(BackEnds, DifferWhereWeightsDiffer) {
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
            kTolerance);
}

TEST(OnnxRuntime, NamesTheModelThatTheCheckerRefuses) {
  const std::string path = JoinPath(Folder("broken"), "broken.onnx");
  ASSERT_THAT(WriteFileAtomically(path, "no model"), IsOk());

  EXPECT_THAT(RunOnnx(Options("refused"), {{.model = path, .inputs = {}}}),
              StatusIs(absl::StatusCode::kInternal,
                       AllOf(HasSubstr("exit code 1"),
                             HasSubstr(absl::StrCat("onnx_check: ", path)))));
}

TEST(OnnxRuntime, NoticesAMissingWeightsFile) {
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

TEST(OnnxRuntime, SaysWhichPythonIsMissing) {
  OnnxRuntimeOptions options = Options("python");
  options.python = "/nowhere/python";

  EXPECT_THAT(
      RunOnnx(options, {{.model = "m", .inputs = {}}}),
      StatusIs(absl::StatusCode::kNotFound, HasSubstr("/nowhere/python")));
}

}  // namespace
}  // namespace sinew::tools
