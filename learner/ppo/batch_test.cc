#include "learner/ppo/batch.h"

#include <cmath>
#include <cstdint>
#include <vector>

#include "common/config/recipe.h"
#include "common/policy/builder.h"
#include "common/random/philox.h"
#include "common/segment/segment_layout.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "learner/ppo/synthetic_segments.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;

constexpr double kDiscount = 0.9, kLambda = 0.8;
constexpr int kSteps = 12, kEnvironments = 3;

// Two segments with episodes that end in every way, some rows invalid.
std::vector<v1::Segment> MakeSegments() {
  const SyntheticProblem problem = {.observation_width = 4,
                                    .action_width = 2,
                                    .orders = 2,
                                    .environments = kEnvironments,
                                    .steps = kSteps,
                                    .terminated_share = 0.1,
                                    .truncated_share = 0.15,
                                    .invalid_share = 0.05};
  const policy::TrackingPolicyOptions network = {
      .observation_width = problem.observation_width,
      .action_width = problem.action_width,
      .network = WithDefaults(v1::Recipe()).network()};
  return MakeSyntheticSegments(problem, *policy::BuildTrackingPolicy(network),
                               *policy::InitialWeights(network, 3), 0);
}

// A finished batch with random values, and those values.
struct Fixture {
  Fixture() : segments(MakeSegments()) {
    EXPECT_THAT(batch.Reset(Pointers(segments)), IsOk());
    values.resize(batch.rows() + batch.bootstrap_rows());
    FillNormal({.seed = 5}, absl::MakeSpan(values));
    std::copy(values.begin(), values.end(), batch.values().begin());
    for (int s = 0; s < batch.num_segments(); ++s) {
      batch.CopyColumns(s);
      batch.ComputeReturns(s);
    }
    figures = batch.Finish();
  }

  std::vector<v1::Segment> segments;
  std::vector<float> values;  // of rows, then of bootstrap rows
  Batch batch{2, MakeSegmentLayout(4, 2), kDiscount, kLambda};
  BatchFigures figures;
};

// Advantages and returns by the textbook's sum over one environment of one
// segment, in double, each step looked at on its own.
struct Textbook {
  const Fixture& f;
  int segment;

  int64_t Row(int t, int e) const {
    return int64_t{segment} * kSteps * kEnvironments + t * kEnvironments + e;
  }
  // In the unit of rewards.
  double Value(int64_t row) const { return f.values[row] / (1 - kDiscount); }

  // Value of what follows step t.
  double NextValue(int t, int e) const {
    const SegmentView& view = f.batch.view(segment);
    const auto blocks = f.batch.Blocks(segment);
    const int64_t flat = t * kEnvironments + e;
    if (view.terminated[flat] != 0) return 0;
    for (size_t k = 0; k < view.truncation_index.size(); ++k) {
      if (view.truncation_index[k] == flat) {
        return Value(blocks[2].first_row + static_cast<int64_t>(k));
      }
    }
    return t + 1 < kSteps ? Value(Row(t + 1, e))
                          : Value(blocks[1].first_row + e);
  }

  double Advantage(int t, int e) const {
    const SegmentView& view = f.batch.view(segment);
    double sum = 0, weight = 1;
    for (int i = t; i < kSteps; ++i) {
      const int64_t flat = i * kEnvironments + e;
      sum += weight * (view.reward[flat] + kDiscount * NextValue(i, e) -
                       Value(Row(i, e)));
      weight *= kDiscount * kLambda;
      if (view.terminated[flat] != 0 || view.truncated[flat] != 0) break;
    }
    return sum;
  }
};

TEST(Batch, TargetsAreTheTextbooksLambdaReturns) {
  const Fixture f;

  for (int s = 0; s < 2; ++s) {
    const Textbook textbook{f, s};
    for (int t = 0; t < kSteps; ++t) {
      for (int e = 0; e < kEnvironments; ++e) {
        const int64_t row = textbook.Row(t, e);
        EXPECT_NEAR(
            f.batch.value_target()[row],
            (1 - kDiscount) * (textbook.Advantage(t, e) + textbook.Value(row)),
            2e-5)
            << "segment " << s << " step " << t << " environment " << e;
      }
    }
  }
}

TEST(Batch, AdvantagesAreTheTextbooksWithMeanZeroAndDeviationOne) {
  const Fixture f;
  std::vector<double> expected, found;
  for (int s = 0; s < 2; ++s) {
    const Textbook textbook{f, s};
    for (int t = 0; t < kSteps; ++t) {
      for (int e = 0; e < kEnvironments; ++e) {
        const int64_t row = textbook.Row(t, e);
        if (f.batch.weight()[row] == 0) continue;
        expected.push_back(textbook.Advantage(t, e));
        found.push_back(f.batch.advantage()[row]);
      }
    }
  }
  double mean = 0, squares = 0;
  for (const double a : expected) mean += a / expected.size();
  for (const double a : expected) squares += (a - mean) * (a - mean);
  const double deviation = std::sqrt(squares / expected.size());

  ASSERT_EQ(static_cast<int64_t>(found.size()), f.figures.valid_rows);
  ASSERT_LT(f.figures.valid_rows, f.batch.rows());  // some are invalid
  for (size_t i = 0; i < found.size(); ++i) {
    EXPECT_NEAR(found[i], (expected[i] - mean) / deviation, 2e-5);
  }
}

TEST(Batch, FiguresAreMeansOverValidRows) {
  const Fixture f;
  double reward = 0, distance = 0, target = 0, error = 0;
  double target_squares = 0, error_squares = 0, n = 0;
  for (int s = 0; s < 2; ++s) {
    const Textbook textbook{f, s};
    const SegmentView& view = f.batch.view(s);
    for (int t = 0; t < kSteps; ++t) {
      for (int e = 0; e < kEnvironments; ++e) {
        const int64_t flat = t * kEnvironments + e;
        if (view.valid[flat] == 0) continue;
        ++n;
        reward += view.reward[flat];
        distance += view.body_distance[flat];
        const double a = textbook.Advantage(t, e);
        const double r = a + textbook.Value(textbook.Row(t, e));
        target += r;
        target_squares += r * r;
        error += a;
        error_squares += a * a;
      }
    }
  }

  EXPECT_NEAR(f.figures.reward_mean, reward / n, 1e-6);
  EXPECT_NEAR(f.figures.body_distance_mean_m, distance / n, 1e-6);
  EXPECT_NEAR(f.figures.explained_variance,
              1 - (error_squares / n - error * error / n / n) /
                      (target_squares / n - target * target / n / n),
              1e-4);
}

}  // namespace
}  // namespace sinew::learner
