#include "common/policy/executor.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <numeric>
#include <string>
#include <vector>

#include "common/policy/testing/examples.h"
#include "common/policy/testing/reference.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::policy {
namespace {

using ::sinew::policy::testing::AllExamples;
using ::sinew::policy::testing::Example;
using ::sinew::policy::testing::ExampleInputs;
using ::sinew::policy::testing::OpExamples;
using ::sinew::policy::testing::PolicyExamples;
using ::sinew::policy::testing::ReferenceValues;
using ::sinew::policy::testing::RelativeDifference;
using ::sinew::policy::testing::RunReference;
using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

using Values = std::map<std::string, std::vector<float>>;

std::shared_ptr<const WeightsPack> Pack(const Example& example) {
  return *PackWeights(example.graph, example.graph_name, example.weights);
}

std::unique_ptr<Executor> MakeExecutor(const Example& example, int max_batch) {
  return *Executor::Create(Pack(example), max_batch);
}

const v1::Graph& GraphOf(const Example& example) {
  return **FindGraph(example.graph, example.graph_name);
}

// Rows `rows` of the inputs through one Run; the taps' rows in that order.
Values RunRows(const Example& example, Executor& executor, const Values& inputs,
               const std::vector<int>& rows) {
  for (const auto& [name, values] : inputs) {
    const int input = executor.input_index(name);
    const int64_t width = executor.input_width(input);
    for (size_t i = 0; i < rows.size(); ++i) {
      std::copy_n(values.begin() + rows[i] * width, width,
                  executor.input(input).begin() + i * width);
    }
  }
  executor.Run(static_cast<int>(rows.size()));
  Values taps;
  for (const v1::Tap& tap : GraphOf(example).taps()) {
    const int index = executor.tap_index(tap.name());
    const auto values = executor.tap(index);
    taps[tap.name()].assign(
        values.begin(),
        values.begin() + rows.size() * executor.tap_width(index));
  }
  return taps;
}

std::vector<int> Range(int count) {
  std::vector<int> rows(count);
  std::iota(rows.begin(), rows.end(), 0);
  return rows;
}

class ExecutorOn : public ::testing::TestWithParam<Example> {};

INSTANTIATE_TEST_SUITE_P(Examples, ExecutorOn,
                         ::testing::ValuesIn(AllExamples()),
                         [](const auto& info) { return info.param.name; });

TEST_P(ExecutorOn, AgreesWithTheReferenceInDouble) {
  constexpr int kBatch = 9;
  const Example& example = GetParam();
  const Values inputs = ExampleInputs(example, kBatch, /*seed=*/1);
  ReferenceValues exact;
  for (const auto& [name, values] : inputs) {
    exact[name].assign(values.begin(), values.end());
  }
  const ReferenceValues expected = RunReference(
      example.graph, example.graph_name, example.weights, exact, kBatch);

  const Values taps =
      RunRows(example, *MakeExecutor(example, kBatch), inputs, Range(kBatch));

  for (const auto& [name, values] : taps) {
    EXPECT_LT(RelativeDifference(values, expected.at(name)), 2e-6) << name;
  }
}

TEST_P(ExecutorOn, GivesARowTheSameBitsWhateverTheBatch) {
  constexpr int kRows = 64;
  const Example& example = GetParam();
  const Values inputs = ExampleInputs(example, kRows, /*seed=*/2);
  auto large = MakeExecutor(example, kRows);
  const Values all = RunRows(example, *large, inputs, Range(kRows));

  // Batches of 1 and 7 in executors of their own and in the large one, whose
  // buffers hold other rows' values.
  for (const int batch : {1, 7}) {
    auto small = MakeExecutor(example, batch);
    for (int first = 0; first + batch <= kRows; first += batch) {
      std::vector<int> rows(batch);
      std::iota(rows.begin(), rows.end(), first);
      const Values fresh = RunRows(example, *small, inputs, rows);
      const Values stale = RunRows(example, *large, inputs, rows);
      for (const auto& [name, values] : fresh) {
        const float* expected =
            all.at(name).data() + values.size() / batch * first;
        const size_t bytes = values.size() * sizeof(float);
        ASSERT_EQ(std::memcmp(values.data(), expected, bytes), 0) << name;
        ASSERT_EQ(std::memcmp(stale.at(name).data(), expected, bytes), 0)
            << name;
      }
    }
  }
}

TEST_P(ExecutorOn, GivesARowTheSameBitsWhereverItStands) {
  constexpr int kRows = 64;
  const Example& example = GetParam();
  const Values inputs = ExampleInputs(example, kRows, /*seed=*/3);
  auto executor = MakeExecutor(example, kRows);
  const Values straight = RunRows(example, *executor, inputs, Range(kRows));
  // 29 and 64 have no common divisor: a permutation.
  std::vector<int> places(kRows);
  for (int i = 0; i < kRows; ++i) places[i] = (29 * i + 5) % kRows;

  const Values permuted = RunRows(example, *executor, inputs, places);

  for (const auto& [name, values] : permuted) {
    const size_t width = values.size() / kRows;
    for (int i = 0; i < kRows; ++i) {
      ASSERT_EQ(std::memcmp(values.data() + i * width,
                            straight.at(name).data() + places[i] * width,
                            width * sizeof(float)),
                0)
          << name << " row " << places[i];
    }
  }
}

// Whether column i is the same in the first two rows: a transposed convolution
// with gaps has columns that depend on no input.
bool IsConstantColumn(const std::vector<float>& values, size_t width,
                      size_t i) {
  return values[i] == values[width + i];
}

TEST_P(ExecutorOn, CarriesNanToItsRowAlone) {
  const Example& example = GetParam();
  Values inputs = ExampleInputs(example, 6, /*seed=*/4);
  auto executor = MakeExecutor(example, 6);
  const Values clean = RunRows(example, *executor, inputs, Range(6));
  for (auto& [name, values] : inputs) {
    const int64_t width = values.size() / 6;
    std::fill_n(values.begin() + 2 * width, width,
                std::numeric_limits<float>::quiet_NaN());
  }

  const Values taps = RunRows(example, *executor, inputs, Range(6));

  for (const auto& [name, values] : taps) {
    const size_t width = values.size() / 6;
    for (size_t i = 0; i < values.size(); ++i) {
      if (i / width == 2) {
        EXPECT_TRUE(std::isnan(values[i]) ||
                    IsConstantColumn(clean.at(name), width, i % width))
            << name << " " << i;
      } else {
        EXPECT_EQ(values[i], clean.at(name)[i]) << name << " " << i;
      }
    }
  }
}

TEST(Executor, EvaluatesEveryOperation) {
  std::set<int> seen;
  for (const Example& example : OpExamples()) {
    for (const v1::Node& node : GraphOf(example).nodes()) {
      seen.insert(node.op());
    }
  }

  for (int op = v1::Op_MIN + 1; op <= v1::Op_MAX; ++op) {
    EXPECT_TRUE(seen.contains(op)) << v1::Op_Name(static_cast<v1::Op>(op));
  }
}

TEST(Executor, FindsInputsAndTapsByName) {
  const Example policy = PolicyExamples()[0];
  auto executor = MakeExecutor(policy, 2);

  EXPECT_EQ(executor->input_width(executor->input_index("observation")), 224);
  EXPECT_EQ(executor->tap_width(executor->tap_index("mean")), 28);
  EXPECT_EQ(executor->input(executor->input_index("noise")).size(), 2 * 28);
  EXPECT_EQ(executor->input_index("mean"), -1);
  EXPECT_EQ(executor->tap_index("observation"), -1);
}

TEST(Executor, TakesNewWeightsOfTheSameGraph) {
  const Example policy = PolicyExamples()[0];
  Example other = policy;
  for (float& bias : other.weights.at("policy/mean/bias").mutable_float32()) {
    bias += 1.0f;
  }
  const Values inputs = ExampleInputs(policy, 3, /*seed=*/5);
  auto executor = MakeExecutor(policy, 3);
  const Values expected =
      RunRows(other, *MakeExecutor(other, 3), inputs, Range(3));

  EXPECT_THAT(executor->SetWeights(Pack(other)), IsOk());

  EXPECT_EQ(RunRows(policy, *executor, inputs, Range(3)), expected);
}

TEST(Executor, RefusesWeightsOfAnotherGraph) {
  const std::vector<Example> policies = PolicyExamples();
  auto executor = MakeExecutor(policies[0], 3);

  EXPECT_THAT(executor->SetWeights(Pack(policies[1])),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("expected weights of the same graph")));
}

TEST(Executor, RefusesAGraphThatIsNotThere) {
  const Example policy = PolicyExamples()[0];

  EXPECT_THAT(PackWeights(policy.graph, "decoder", policy.weights),
              StatusIs(absl::StatusCode::kNotFound,
                       "expected a graph named \"decoder\", found [policy, "
                       "critic]"));
}

TEST(Executor, RefusesABatchOutOfRange) {
  const Example policy = PolicyExamples()[0];

  EXPECT_THAT(Executor::Create(Pack(policy), 0),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("max_batch: expected 1 to 65536, found 0")));
}

TEST(Executor, RunsAnEmptyBatch) {
  const Example policy = PolicyExamples()[0];

  MakeExecutor(policy, 3)->Run(0);
}

TEST(Executor, BreaksTiesTowardsTheFirstCode) {
  const Example quantiser = [] {
    for (Example& example : OpExamples()) {
      if (example.name == "argmin_gather") return example;
    }
    return Example();
  }();
  Example tied = quantiser;
  // Codes 4, 17 and 20 are the point 0, all others are farther away.
  auto codes = tied.weights.at("index/0").mutable_float32();
  std::fill(codes.begin(), codes.end(), 3.0f);
  for (const int code : {4, 17, 20}) {
    std::fill_n(codes.begin() + code * 6, 6, 0.0f);
  }

  const Values taps = RunRows(tied, *MakeExecutor(tied, 1),
                              {{"x", std::vector<float>(6, 0.5f)}}, {0});

  EXPECT_THAT(taps.at("index_of_code"), ElementsAre(4.0f));
}

TEST(Executor, GathersNanForAnIndexOutsideTheCodebook) {
  Example gather;
  gather.graph_name = "gather";
  gather.graph.set_format_version(1);
  v1::Graph* graph = gather.graph.add_graphs();
  graph->set_name("gather");
  v1::GraphInput* input = graph->add_inputs();
  input->set_name("index");
  input->set_width(1);
  input->set_kind(v1::GraphInput::KIND_DATA);
  v1::Node* node = graph->add_nodes();
  node->set_name("row");
  node->set_op(v1::OP_GATHER);
  node->add_inputs("index");
  node->add_parameters("codebook");
  v1::Tap* tap = graph->add_taps();
  tap->set_name("code");
  tap->set_value("row");
  v1::Parameter* parameter = gather.graph.add_parameters();
  parameter->set_name("codebook");
  parameter->add_shape(3);
  parameter->add_shape(2);
  gather.weights["codebook"] =
      HostTensor::Float32({3, 2}, {0.f, 1.f, 10.f, 11.f, 20.f, 21.f});
  const std::vector<float> indices = {2.0f, 1.9f, -1.0f, 3.0f, 1e20f};

  const auto codes =
      RunRows(gather, *MakeExecutor(gather, 5), {{"index", indices}}, Range(5))
          .at("code");

  EXPECT_THAT(absl::MakeSpan(codes).first(4), ElementsAre(20, 21, 10, 11));
  for (size_t i = 4; i < 10; ++i) EXPECT_TRUE(std::isnan(codes[i])) << i;
}

}  // namespace
}  // namespace sinew::policy
