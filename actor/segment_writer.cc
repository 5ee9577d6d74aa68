#include "actor/segment_writer.h"

#include <cstring>
#include <string>

#include "common/check.h"

namespace sinew::actor {
namespace {

template <typename T>
void WriteRow(char* column, int64_t row, absl::Span<const T> values) {
  std::memcpy(column + row * values.size() * sizeof(T), values.data(),
              values.size() * sizeof(T));
}

template <typename T>
void WriteScalar(char* column, int64_t row, T value) {
  std::memcpy(column + row * sizeof(T), &value, sizeof(T));
}

template <typename T>
void Append(v1::Tensor* column, absl::Span<const T> values) {
  column->mutable_data()->append(reinterpret_cast<const char*>(values.data()),
                                 values.size() * sizeof(T));
}

// Adds a column of zeros.
void AddColumn(const v1::SegmentLayout::Column& column, int steps,
               int environments, v1::Segment* segment) {
  v1::Tensor* tensor = segment->add_columns();
  tensor->set_name(column.name());
  tensor->set_dtype(column.dtype());
  int64_t rows = 0;
  if (column.lead() == v1::SegmentLayout::LEAD_STEP) {
    tensor->add_shape(steps);
    tensor->add_shape(environments);
    rows = int64_t{steps} * environments;
  } else if (column.lead() == v1::SegmentLayout::LEAD_BOUNDARY) {
    tensor->add_shape(environments);
    rows = environments;
  } else {
    tensor->add_shape(0);
  }
  for (int64_t extent : column.shape()) {
    tensor->add_shape(extent);
    rows *= extent;
  }
  tensor->mutable_data()->assign(rows * ElementBytes(column.dtype()), '\0');
}

}  // namespace

SegmentWriter::SegmentWriter(const v1::SegmentLayout& layout, int steps,
                             int environments, v1::Segment* segment)
    : segment_(segment), environments_(environments) {
  for (const v1::SegmentLayout::Column& column : layout.columns()) {
    AddColumn(column, steps, environments, segment);
  }
  const auto begin = [this](absl::string_view name) {
    return Column(name)->mutable_data()->data();
  };
  observation_ = begin(column::kObservation);
  action_ = begin(column::kAction);
  action_mean_ = begin(column::kActionMean);
  target_ = begin(column::kTarget);
  log_probability_ = begin(column::kLogProbability);
  reward_ = begin(column::kReward);
  reward_terms_ = begin(column::kRewardTerms);
  body_distance_ = begin(column::kBodyDistance);
  terminated_ = begin(column::kTerminated);
  truncated_ = begin(column::kTruncated);
  valid_ = begin(column::kValid);
  clip_ = begin(column::kClip);
  frame_ = begin(column::kFrame);
  boundary_ = begin(column::kBoundaryObservation);
  if (FindColumn(*segment, column::kBase) != nullptr) {
    base_ = begin(column::kBase);
    teacher_base_ = begin(column::kTeacherBase);
  }
  if (FindColumn(*segment, column::kLatentNoise) != nullptr) {
    latent_noise_ = begin(column::kLatentNoise);
  }
}

v1::Tensor* SegmentWriter::Column(absl::string_view name) const {
  v1::Tensor* column = FindColumn(*segment_, name);
  SINEW_CHECK(column != nullptr) << "segment layout lacks column " << name;
  return column;
}

void SegmentWriter::WriteStep(int step, int environment, const StepRow& row) {
  const int64_t i = int64_t{step} * environments_ + environment;
  const world::StepResult& result = *row.result;
  WriteRow(observation_, i, row.observation);
  WriteRow(action_, i, row.action);
  WriteRow(action_mean_, i, row.action_mean);
  WriteRow(target_, i, row.target);
  WriteScalar(log_probability_, i, static_cast<float>(row.log_probability));
  WriteScalar(reward_, i, result.reward);
  WriteRow(reward_terms_, i, absl::MakeConstSpan(result.reward_terms));
  WriteScalar(body_distance_, i, result.mean_body_distance);
  WriteScalar<uint8_t>(terminated_, i, result.terminated ? 1 : 0);
  WriteScalar<uint8_t>(truncated_, i, result.truncated ? 1 : 0);
  WriteScalar<uint8_t>(valid_, i, result.diverged ? 0 : 1);
  WriteScalar(clip_, i, row.clip);
  WriteScalar(frame_, i, row.frame);
  if (base_ != nullptr) {
    WriteRow(base_, i, row.base);
    WriteRow(teacher_base_, i, row.teacher_base);
  }
  if (latent_noise_ != nullptr) WriteRow(latent_noise_, i, row.latent_noise);
}

void SegmentWriter::WriteTruncation(int step, int environment,
                                    absl::Span<const float> observation) {
  const int32_t index = step * environments_ + environment;
  Append(Column(column::kTruncationIndex), absl::MakeConstSpan(&index, 1));
  Append(Column(column::kTruncationObservation), observation);
  ++truncations_;
}

void SegmentWriter::WriteBoundary(int environment,
                                  absl::Span<const float> observation) {
  WriteRow(boundary_, environment, observation);
}

void SegmentWriter::Finish() {
  Column(column::kTruncationIndex)->set_shape(0, truncations_);
  Column(column::kTruncationObservation)->set_shape(0, truncations_);
}

}  // namespace sinew::actor
