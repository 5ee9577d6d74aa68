#include "learner/ppo/synthetic_segments.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <utility>

#include "absl/types/span.h"
#include "common/check.h"
#include "common/policy/executor.h"
#include "common/random/philox.h"
#include "common/segment/segment_layout.h"

namespace sinew::learner {
namespace {

constexpr float kShift = 3;
constexpr float kScale = 2;

// Streams of one (order, iteration).
enum Stream : uint64_t { kObservations, kNoise, kEnds, kWeights, kLatents };

RandomKey Key(const SyntheticProblem& problem, int64_t iteration, int order,
              Stream stream) {
  return {.seed = problem.seed,
          .environment = static_cast<uint64_t>(order),
          .episode = static_cast<uint64_t>(iteration),
          .step = stream,
          .purpose = RandomPurpose::kAction};
}

std::vector<float> Normal(const RandomKey& key, int64_t size) {
  std::vector<float> values(size);
  FillNormal(key, absl::MakeSpan(values));
  return values;
}

// Collects columns by name and writes them in the layout's order.
class SegmentWriter {
 public:
  SegmentWriter(const SyntheticProblem& problem)
      : layout_(
            MakeSegmentLayout(problem.observation_width, problem.action_width,
                              /*distillation=*/false, problem.latent_width)),
        problem_(problem) {}

  template <typename T>
  void Set(absl::string_view name, const std::vector<T>& values) {
    data_[std::string(name)] =
        std::string(reinterpret_cast<const char*>(values.data()),
                    values.size() * sizeof(T));
  }

  void Write(int64_t truncations, v1::Segment& segment) const {
    for (const auto& column : layout_.columns()) {
      v1::Tensor* tensor = segment.add_columns();
      tensor->set_name(column.name());
      tensor->set_dtype(column.dtype());
      if (column.lead() == v1::SegmentLayout::LEAD_STEP) {
        tensor->add_shape(problem_.steps);
      }
      tensor->add_shape(column.lead() == v1::SegmentLayout::LEAD_TRUNCATION
                            ? truncations
                            : problem_.environments);
      tensor->mutable_shape()->MergeFrom(column.shape());
      int64_t bytes = ElementBytes(column.dtype());
      for (const int64_t extent : tensor->shape()) bytes *= extent;
      const auto found = data_.find(column.name());
      tensor->set_data(found == data_.end() ? std::string(bytes, '\0')
                                            : found->second);
      SINEW_CHECK(static_cast<int64_t>(tensor->data().size()) == bytes)
          << column.name();
    }
  }

 private:
  const v1::SegmentLayout layout_;
  const SyntheticProblem& problem_;
  std::map<std::string, std::string> data_;
};

std::vector<float> Observations(const SyntheticProblem& problem,
                                int64_t iteration, int order, int64_t rows) {
  std::vector<float> values =
      Normal(Key(problem, iteration, order, kObservations),
             rows * problem.observation_width);
  for (float& value : values) value = kShift + kScale * value;
  return values;
}

// f of every row.
std::vector<double> RightActions(const SyntheticProblem& problem,
                                 const std::vector<float>& observations,
                                 int64_t rows) {
  const int64_t in = problem.observation_width;
  const int64_t out = problem.action_width;
  const std::vector<float> w = Normal(Key(problem, 0, 0, kWeights), in * out);
  std::vector<double> right(rows * out);
  for (int64_t r = 0; r < rows; ++r) {
    for (int64_t o = 0; o < out; ++o) {
      double sum = 0;
      for (int64_t i = 0; i < in; ++i) {
        sum += w[o * in + i] * (observations[r * in + i] - kShift) / kScale;
      }
      right[r * out + o] = std::tanh(sum / std::sqrt(in));
    }
  }
  return right;
}

// Noise of all rows, of the action and of the latent.
struct Noise {
  std::vector<float> action, latent;
};

struct Acted {
  std::vector<float> action, mean, log_probability;
};

void SetInput(policy::Executor& executor, const char* name, const float* rows,
              int64_t size) {
  std::copy_n(rows, size, executor.input(executor.input_index(name)).begin());
}

Acted Act(const SyntheticProblem& problem, policy::Executor& executor,
          absl::Span<const float> std, const std::vector<float>& observations,
          const Noise& noise, int64_t rows) {
  const int64_t in = problem.observation_width;
  const int64_t out = problem.action_width;
  Acted acted;
  acted.log_probability.resize(rows);
  const int batch = problem.environments;
  for (int64_t r = 0; r < rows; r += batch) {
    const int64_t z = problem.latent_width;
    SetInput(executor, "observation", &observations[r * in], batch * in);
    SetInput(executor, z > 0 ? "action_noise" : "noise", &noise.action[r * out],
             batch * out);
    if (z > 0) SetInput(executor, "noise", &noise.latent[r * z], batch * z);
    executor.Run(batch);
    for (auto [name, column] :
         {std::pair{"action", &acted.action}, std::pair{"mean", &acted.mean}}) {
      const auto tap = executor.tap(executor.tap_index(name));
      column->insert(column->end(), tap.begin(), tap.begin() + batch * out);
    }
  }
  for (int64_t r = 0; r < rows; ++r) {
    double sum = 0;
    for (int64_t o = 0; o < out; ++o) {
      const double z = noise.action[r * out + o];
      sum -=
          0.5 * z * z + std::log(std[o]) + 0.5 * std::log(2 * std::numbers::pi);
    }
    acted.log_probability[r] = static_cast<float>(sum);
  }
  return acted;
}

// Flags and rewards.
struct Outcome {
  std::vector<uint8_t> terminated, truncated, valid;
  std::vector<int32_t> truncation_index;
  std::vector<float> reward, reward_terms, body_distance;
};

Outcome Judge(const SyntheticProblem& problem, const RandomKey& ends,
              const Acted& acted, const std::vector<double>& right,
              int64_t rows) {
  Outcome outcome;
  std::vector<float> uniform(rows);
  FillUniform(ends, absl::MakeSpan(uniform));
  const double invalid = problem.invalid_share;
  const double terminated = invalid + problem.terminated_share;
  const double truncated = terminated + problem.truncated_share;
  const int64_t out = problem.action_width;
  for (int64_t r = 0; r < rows; ++r) {
    const double u = uniform[r];
    const bool is_truncated = u >= terminated && u < truncated;
    outcome.valid.push_back(u >= invalid);
    outcome.terminated.push_back(u < terminated);
    outcome.truncated.push_back(is_truncated);
    if (is_truncated) {
      outcome.truncation_index.push_back(static_cast<int32_t>(r));
    }
    double squares = 0;
    for (int64_t i = r * out; i < (r + 1) * out; ++i) {
      squares += (acted.action[i] - right[i]) * (acted.action[i] - right[i]);
    }
    outcome.reward.push_back(
        u < invalid ? 0.0f : static_cast<float>(std::exp(-squares / 2)));
    for (int k = 0; k < kNumRewardTerms; ++k) {
      outcome.reward_terms.push_back(outcome.reward.back());
    }
    outcome.body_distance.push_back(static_cast<float>(std::sqrt(squares)));
  }
  return outcome;
}

v1::Segment MakeSegment(const SyntheticProblem& problem, int64_t iteration,
                        int order, policy::Executor& executor,
                        absl::Span<const float> std) {
  const int64_t rows = int64_t{problem.steps} * problem.environments;
  const std::vector<float> observations =
      Observations(problem, iteration, order, rows);
  const std::vector<double> right = RightActions(problem, observations, rows);
  const Noise noise = {
      .action = Normal(Key(problem, iteration, order, kNoise),
                       rows * problem.action_width),
      .latent = Normal(Key(problem, iteration, order, kLatents),
                       rows * problem.latent_width)};
  const Acted acted = Act(problem, executor, std, observations, noise, rows);
  const Outcome outcome =
      Judge(problem, Key(problem, iteration, order, kEnds), acted, right, rows);
  const int64_t truncations =
      static_cast<int64_t>(outcome.truncation_index.size());

  SegmentWriter writer(problem);
  writer.Set(column::kObservation, observations);
  writer.Set(column::kAction, acted.action);
  writer.Set(column::kActionMean, acted.mean);
  writer.Set(column::kTarget, right);
  writer.Set(column::kLogProbability, acted.log_probability);
  writer.Set(column::kLatentNoise, noise.latent);
  writer.Set(column::kReward, outcome.reward);
  writer.Set(column::kRewardTerms, outcome.reward_terms);
  writer.Set(column::kBodyDistance, outcome.body_distance);
  writer.Set(column::kTerminated, outcome.terminated);
  writer.Set(column::kTruncated, outcome.truncated);
  writer.Set(column::kValid, outcome.valid);
  writer.Set(column::kTruncationIndex, outcome.truncation_index);
  // Successors are observations like all others.
  writer.Set(column::kBoundaryObservation,
             Observations(problem, iteration, order, problem.environments));
  writer.Set(column::kTruncationObservation,
             Observations(problem, iteration, order, truncations));
  v1::Segment segment;
  segment.set_order_id(order);
  segment.set_kind(v1::Order::KIND_TRAIN);
  segment.set_iteration(iteration);
  writer.Write(truncations, segment);
  return segment;
}

}  // namespace

std::vector<v1::Segment> MakeSyntheticSegments(const SyntheticProblem& problem,
                                               const v1::PolicyGraph& graph,
                                               const TensorMap& weights,
                                               int64_t iteration) {
  auto pack = policy::PackWeights(graph, "policy", weights);
  SINEW_CHECK(pack.ok()) << pack.status().ToString();
  auto executor = policy::Executor::Create(*pack, problem.environments);
  SINEW_CHECK(executor.ok()) << executor.status().ToString();
  std::vector<v1::Segment> segments;
  for (int order = 0; order < problem.orders; ++order) {
    segments.push_back(MakeSegment(problem, iteration, order, **executor,
                                   weights.at("policy/std").float32()));
  }
  return segments;
}

std::vector<const v1::Segment*> Pointers(
    const std::vector<v1::Segment>& segments) {
  std::vector<const v1::Segment*> pointers;
  for (const v1::Segment& segment : segments) pointers.push_back(&segment);
  return pointers;
}

double MeanActionError(const std::vector<v1::Segment>& segments) {
  double sum = 0, count = 0;
  for (const v1::Segment& segment : segments) {
    const std::string& mean = FindColumn(segment, column::kActionMean)->data();
    const std::string& right = FindColumn(segment, column::kTarget)->data();
    const auto* m = reinterpret_cast<const float*>(mean.data());
    const auto* f = reinterpret_cast<const double*>(right.data());
    for (size_t i = 0; i < mean.size() / sizeof(float); ++i) {
      sum += (m[i] - f[i]) * (m[i] - f[i]);
      count += 1;
    }
  }
  return sum / count;
}

}  // namespace sinew::learner
