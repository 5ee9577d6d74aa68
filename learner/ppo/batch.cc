#include "learner/ppo/batch.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/check.h"
#include "common/segment/segment_layout.h"
#include "common/status_macros.h"
#include "learner/ppo/gae.h"

namespace sinew::learner {
namespace {

// Smallest standard deviation that advantages are divided by.
constexpr double kLeastDeviation = 1e-8;

}  // namespace

Batch::Batch(int64_t action_width, v1::SegmentLayout layout, double discount,
             double lambda)
    : action_width_(action_width),
      layout_(std::move(layout)),
      discount_(discount),
      lambda_(lambda) {}

absl::Status Batch::Reset(absl::Span<const v1::Segment* const> segments,
                          int64_t images) {
  views_.clear();
  first_row_.clear();
  first_bootstrap_.clear();
  rows_ = bootstrap_rows_ = 0;
  first_image_ = static_cast<int64_t>(segments.size()) - images;
  for (const v1::Segment* segment : segments) {
    SINEW_ASSIGN_OR_RETURN(const SegmentView view,
                           ViewSegment(*segment, layout_));
    views_.push_back(view);
    first_row_.push_back(rows_);
    first_bootstrap_.push_back(bootstrap_rows_);
    rows_ += view.rows();
    bootstrap_rows_ +=
        view.environments + static_cast<int64_t>(view.truncation_index.size());
  }
  values_.resize(rows_ + bootstrap_rows_);
  action_.resize(rows_ * action_width_);
  action_mean_.resize(rows_ * action_width_);
  for (auto* column : {&next_values_, &log_probability_, &advantage_,
                       &value_target_, &weight_, &acted_}) {
    column->resize(rows_);
  }
  return absl::OkStatus();
}

std::vector<Batch::Block> Batch::Blocks(int segment) const {
  const SegmentView& view = views_[segment];
  const int64_t bootstrap = rows_ + first_bootstrap_[segment];
  return {{first_row_[segment], view.observation, view.latent_noise},
          {bootstrap, view.boundary_observation},
          {bootstrap + view.environments, view.truncation_observation}};
}

void Batch::CopyColumns(int segment) {
  const SegmentView& view = views_[segment];
  const int64_t row = first_row_[segment];
  const int64_t element = row * action_width_;
  std::copy(view.action.begin(), view.action.end(), &action_[element]);
  std::copy(view.action_mean.begin(), view.action_mean.end(),
            &action_mean_[element]);
  std::copy(view.log_probability.begin(), view.log_probability.end(),
            &log_probability_[row]);
  std::transform(view.valid.begin(), view.valid.end(), &weight_[row],
                 [](uint8_t valid) { return valid != 0 ? 1.0f : 0.0f; });
  if (segment < first_image_) {
    std::copy_n(&weight_[row], view.rows(), &acted_[row]);
  } else {
    std::fill_n(&acted_[row], view.rows(), 0.0f);
  }
}

void Batch::ComputeReturns(int segment) {
  const SegmentView& view = views_[segment];
  const int64_t row = first_row_[segment];
  const size_t size = view.rows();
  const float scale = static_cast<float>(1 - discount_);
  const absl::Span<float> values(&values_[row], size);
  const absl::Span<float> bootstraps(
      &values_[rows_ + first_bootstrap_[segment]],
      view.environments + view.truncation_index.size());
  for (float& value : values) value /= scale;
  for (float& value : bootstraps) value /= scale;

  const absl::Span<float> next(&next_values_[row], size);
  FillNextValues(values, bootstraps.subspan(0, view.environments),
                 view.truncation_index, bootstraps.subspan(view.environments),
                 next);
  const absl::Span<float> targets(&value_target_[row], size);
  ComputeGae({view.steps, view.environments, view.reward, values, next,
              view.terminated, view.truncated},
             discount_, lambda_, {&advantage_[row], size}, targets);
  for (float& target : targets) target *= scale;
}

BatchFigures Batch::Finish() {
  BatchFigures figures;
  figures.reward_terms.resize(kNumRewardTerms);
  double sum = 0;
  for (size_t s = 0; s < views_.size(); ++s) {
    const SegmentView& view = views_[s];
    for (int64_t i = 0; i < view.rows(); ++i) {
      if (view.valid[i] == 0) continue;
      ++figures.valid_rows;
      sum += advantage_[first_row_[s] + i];
      figures.reward_mean += view.reward[i];
      figures.body_distance_mean_m += view.body_distance[i];
      for (int k = 0; k < kNumRewardTerms; ++k) {
        figures.reward_terms[k] += view.reward_terms[i * kNumRewardTerms + k];
      }
    }
  }
  const double count =
      static_cast<double>(std::max<int64_t>(1, figures.valid_rows));
  figures.reward_mean /= count;
  figures.body_distance_mean_m /= count;
  for (double& term : figures.reward_terms) term /= count;
  figures.explained_variance = ExplainedVariance(figures.valid_rows);

  const double mean = sum / count;
  double squares = 0;
  for (int64_t i = 0; i < rows_; ++i) {
    squares += weight_[i] * (advantage_[i] - mean) * (advantage_[i] - mean);
  }
  const double inverse = 1.0 / (std::sqrt(squares / count) + kLeastDeviation);
  for (float& advantage : advantage_) {
    advantage = static_cast<float>((advantage - mean) * inverse);
  }
  return figures;
}

double Batch::ExplainedVariance(int64_t valid_rows) const {
  // The error of a value is the advantage: R - V = A.
  double sum = 0, squares = 0, error_sum = 0, error_squares = 0;
  for (int64_t i = 0; i < rows_; ++i) {
    if (weight_[i] == 0) continue;
    const double target = value_target_[i] / (1 - discount_);
    const double error = advantage_[i];
    sum += target;
    squares += target * target;
    error_sum += error;
    error_squares += error * error;
  }
  const double n = static_cast<double>(std::max<int64_t>(1, valid_rows));
  const double variance = squares / n - sum * sum / n / n;
  const double rest = error_squares / n - error_sum * error_sum / n / n;
  return variance > 0 ? 1.0 - rest / variance : 0.0;
}

}  // namespace sinew::learner
