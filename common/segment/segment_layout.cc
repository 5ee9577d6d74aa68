#include "common/segment/segment_layout.h"

#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/string_view.h"
#include "common/digest.h"
#include "common/status_macros.h"

namespace sinew {
namespace {

using Layout = v1::SegmentLayout;

void AddColumn(Layout& layout, absl::string_view name, v1::DataType dtype,
               Layout::Lead lead, std::initializer_list<int64_t> shape = {}) {
  Layout::Column* column = layout.add_columns();
  column->set_name(std::string(name));
  column->set_dtype(dtype);
  column->set_lead(lead);
  for (int64_t extent : shape) column->add_shape(extent);
}

std::string ShapeText(const google::protobuf::RepeatedField<int64_t>& shape) {
  return absl::StrCat("[", absl::StrJoin(shape, ", "), "]");
}

// Shape that a column must have; `truncations` is K.
google::protobuf::RepeatedField<int64_t> ExpectedShape(
    const Layout::Column& column, int64_t steps, int64_t environments,
    int64_t truncations) {
  google::protobuf::RepeatedField<int64_t> shape;
  if (column.lead() == Layout::LEAD_STEP) shape.Add(steps);
  shape.Add(column.lead() == Layout::LEAD_TRUNCATION ? truncations
                                                     : environments);
  shape.MergeFrom(column.shape());
  return shape;
}

absl::Status CheckColumn(const v1::Tensor& found, const Layout::Column& column,
                         int64_t steps, int64_t environments,
                         int64_t truncations) {
  if (found.name() != column.name()) {
    return absl::InvalidArgumentError(
        absl::StrCat("segment column: expected \"", column.name(),
                     "\", found \"", found.name(), "\""));
  }
  if (found.dtype() != column.dtype()) {
    return absl::InvalidArgumentError(
        absl::StrCat("segment column ", column.name(), ": expected type ",
                     v1::DataType_Name(column.dtype()), ", found ",
                     v1::DataType_Name(found.dtype())));
  }
  const auto expected = ExpectedShape(column, steps, environments, truncations);
  int64_t bytes = ElementBytes(column.dtype());
  for (int64_t extent : expected) bytes *= extent;
  if (ShapeText(found.shape()) != ShapeText(expected)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "segment column ", column.name(), ": expected shape ",
        ShapeText(expected), ", found ", ShapeText(found.shape())));
  }
  if (static_cast<int64_t>(found.data().size()) != bytes) {
    return absl::InvalidArgumentError(
        absl::StrCat("segment column ", column.name(), ": expected ", bytes,
                     " bytes, found ", found.data().size()));
  }
  return absl::OkStatus();
}

// Flat indices of the steps whose flag is set; error if a flag is not 0 or 1.
absl::StatusOr<std::vector<int32_t>> SetFlags(const v1::Tensor& flags) {
  std::vector<int32_t> set;
  for (size_t i = 0; i < flags.data().size(); ++i) {
    const auto value = static_cast<unsigned char>(flags.data()[i]);
    if (value > 1) {
      return absl::InvalidArgumentError(
          absl::StrCat("segment column ", flags.name(), "[", i,
                       "]: expected 0 or 1, found ", value));
    }
    if (value == 1) set.push_back(static_cast<int32_t>(i));
  }
  return set;
}

absl::Status CheckFlags(const v1::Segment& segment) {
  const v1::Tensor* terminated = FindColumn(segment, column::kTerminated);
  const v1::Tensor* truncated = FindColumn(segment, column::kTruncated);
  const v1::Tensor* valid = FindColumn(segment, column::kValid);
  const v1::Tensor* index = FindColumn(segment, column::kTruncationIndex);
  if (terminated == nullptr || truncated == nullptr || valid == nullptr ||
      index == nullptr) {
    return absl::OkStatus();  // A layout without flags has nothing to check.
  }
  SINEW_RETURN_IF_ERROR(SetFlags(*terminated).status());
  SINEW_RETURN_IF_ERROR(SetFlags(*valid).status());
  SINEW_ASSIGN_OR_RETURN(std::vector<int32_t> steps, SetFlags(*truncated));
  for (int32_t step : steps) {
    if (terminated->data()[step] != 0) {
      return absl::InvalidArgumentError(absl::StrCat(
          "segment step ", step, ": both terminated and truncated"));
    }
  }
  const absl::string_view expected(reinterpret_cast<const char*>(steps.data()),
                                   steps.size() * sizeof(int32_t));
  if (index->data() != expected) {
    return absl::InvalidArgumentError(
        absl::StrCat("segment column truncation_index: expected the ",
                     steps.size(), " truncated steps, found ",
                     index->data().size() / sizeof(int32_t), " indices"));
  }
  return absl::OkStatus();
}

template <typename T>
absl::Status CheckFinite(const v1::Tensor& tensor) {
  for (size_t i = 0; i + sizeof(T) <= tensor.data().size(); i += sizeof(T)) {
    T value;
    std::memcpy(&value, tensor.data().data() + i, sizeof(T));
    if (!std::isfinite(value)) {
      return absl::InvalidArgumentError(
          absl::StrCat("segment column ", tensor.name(), "[", i / sizeof(T),
                       "]: expected a finite number, found ", value));
    }
  }
  return absl::OkStatus();
}

}  // namespace

v1::SegmentLayout MakeSegmentLayout(int64_t observation_width,
                                    int64_t action_width, bool distillation,
                                    int64_t latent_noise_width) {
  constexpr auto kFloat = v1::DATA_TYPE_FLOAT32;
  constexpr auto kFlag = v1::DATA_TYPE_UINT8;
  constexpr auto kInt = v1::DATA_TYPE_INT32;
  constexpr auto kStep = Layout::LEAD_STEP;
  Layout layout;
  AddColumn(layout, column::kObservation, kFloat, kStep, {observation_width});
  AddColumn(layout, column::kAction, kFloat, kStep, {action_width});
  AddColumn(layout, column::kActionMean, kFloat, kStep, {action_width});
  AddColumn(layout, column::kTarget, v1::DATA_TYPE_FLOAT64, kStep,
            {action_width});
  AddColumn(layout, column::kLogProbability, kFloat, kStep);
  AddColumn(layout, column::kReward, kFloat, kStep);
  AddColumn(layout, column::kRewardTerms, kFloat, kStep, {kNumRewardTerms});
  AddColumn(layout, column::kBodyDistance, kFloat, kStep);
  AddColumn(layout, column::kTerminated, kFlag, kStep);
  AddColumn(layout, column::kTruncated, kFlag, kStep);
  AddColumn(layout, column::kValid, kFlag, kStep);
  AddColumn(layout, column::kClip, kInt, kStep);
  AddColumn(layout, column::kFrame, kInt, kStep);
  if (distillation) {
    for (const absl::string_view name : {column::kBase, column::kTeacherBase}) {
      AddColumn(layout, name, v1::DATA_TYPE_FLOAT64, kStep, {action_width});
    }
  }
  if (latent_noise_width > 0) {
    AddColumn(layout, column::kLatentNoise, kFloat, kStep,
              {latent_noise_width});
  }
  AddColumn(layout, column::kBoundaryObservation, kFloat, Layout::LEAD_BOUNDARY,
            {observation_width});
  AddColumn(layout, column::kTruncationIndex, kInt, Layout::LEAD_TRUNCATION);
  AddColumn(layout, column::kTruncationObservation, kFloat,
            Layout::LEAD_TRUNCATION, {observation_width});
  return layout;
}

std::string LayoutSha256(const v1::SegmentLayout& layout) {
  return Sha256Hex(SerializeDeterministically(layout));
}

const v1::Tensor* FindColumn(const v1::Segment& segment,
                             absl::string_view name) {
  for (const v1::Tensor& tensor : segment.columns()) {
    if (tensor.name() == name) return &tensor;
  }
  return nullptr;
}

v1::Tensor* FindColumn(v1::Segment& segment, absl::string_view name) {
  for (v1::Tensor& column : *segment.mutable_columns()) {
    if (column.name() == name) return &column;
  }
  return nullptr;
}

int64_t ElementBytes(v1::DataType dtype) {
  switch (dtype) {
    case v1::DATA_TYPE_FLOAT32:
    case v1::DATA_TYPE_INT32:
      return 4;
    case v1::DATA_TYPE_FLOAT64:
    case v1::DATA_TYPE_INT64:
      return 8;
    case v1::DATA_TYPE_UINT8:
      return 1;
    default:
      return 0;
  }
}

absl::Status CheckColumns(const v1::Segment& segment,
                          const v1::SegmentLayout& layout, int64_t steps,
                          int64_t environments) {
  if (segment.columns_size() != layout.columns_size()) {
    return absl::InvalidArgumentError(
        absl::StrCat("segment: expected ", layout.columns_size(),
                     " columns, found ", segment.columns_size()));
  }
  const v1::Tensor* index = FindColumn(segment, column::kTruncationIndex);
  int64_t truncations = 0;
  if (index != nullptr && index->shape_size() > 0) {
    truncations = index->shape(0);
  }
  if (truncations < 0 || truncations > steps * environments) {
    return absl::InvalidArgumentError(
        absl::StrCat("segment column truncation_index: expected at most ",
                     steps * environments, " rows, found ", truncations));
  }
  for (int i = 0; i < layout.columns_size(); ++i) {
    SINEW_RETURN_IF_ERROR(CheckColumn(segment.columns(i), layout.columns(i),
                                      steps, environments, truncations));
  }
  return CheckFlags(segment);
}

absl::Status CheckColumnsFinite(const v1::Segment& segment) {
  for (const v1::Tensor& tensor : segment.columns()) {
    if (tensor.dtype() == v1::DATA_TYPE_FLOAT32) {
      SINEW_RETURN_IF_ERROR(CheckFinite<float>(tensor));
    } else if (tensor.dtype() == v1::DATA_TYPE_FLOAT64) {
      SINEW_RETURN_IF_ERROR(CheckFinite<double>(tensor));
    }
  }
  return absl::OkStatus();
}

}  // namespace sinew
