#include "common/segment/mirror.h"

#include <algorithm>
#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/check.h"
#include "common/segment/segment_layout.h"
#include "common/status_macros.h"

namespace sinew {
namespace {

// Mirrors the rows of a float32 column in place.
absl::Status MirrorColumn(const RowMirror& mirror, v1::Tensor& column) {
  const int width = mirror.width();
  const int64_t found =
      column.shape_size() > 0 ? column.shape(column.shape_size() - 1) : 0;
  const size_t bytes = sizeof(float) * width;
  if (column.dtype() != v1::DATA_TYPE_FLOAT32 || found != width ||
      column.data().size() % bytes != 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("segment column ", column.name(),
                     ": expected float32 rows of ", width, " to mirror, found ",
                     v1::DataType_Name(column.dtype()), " rows of ", found));
  }
  auto* values = reinterpret_cast<float*>(column.mutable_data()->data());
  const size_t rows = column.data().size() / bytes;
  std::vector<float> mirrored(width);
  for (size_t i = 0; i < rows; ++i) {
    float* row = values + i * width;
    mirror.Apply({row, static_cast<size_t>(width)}, absl::MakeSpan(mirrored));
    std::copy(mirrored.begin(), mirrored.end(), row);
  }
  return absl::OkStatus();
}

}  // namespace

void RowMirror::Apply(absl::Span<const float> row,
                      absl::Span<float> mirrored) const {
  SINEW_DCHECK(row.size() == source.size());
  SINEW_DCHECK(mirrored.size() == source.size());
  for (size_t i = 0; i < source.size(); ++i) {
    mirrored[i] = sign[i] * row[source[i]];
  }
}

absl::Status CheckRowMirror(const RowMirror& mirror) {
  const int width = mirror.width();
  const bool sizes = mirror.sign.size() == mirror.source.size();
  for (int i = 0; sizes && i < width; ++i) {
    const int j = mirror.source[i];
    if (j < 0 || j >= width || mirror.source[j] != i ||
        mirror.sign[i] * mirror.sign[j] != 1) {
      return absl::InvalidArgumentError(absl::StrCat(
          "mirror: expected column ", i, " to be mirrored by the one that it ",
          "mirrors, with an equal sign; found source ", j));
    }
  }
  if (sizes) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      "mirror: expected ", width, " signs, found ", mirror.sign.size()));
}

absl::StatusOr<v1::Segment> MirrorSegment(const v1::Segment& segment,
                                          const SegmentMirror& mirror) {
  v1::Segment mirrored = segment;
  for (v1::Tensor& column : *mirrored.mutable_columns()) {
    const absl::string_view name = column.name();
    if (name == column::kObservation || name == column::kBoundaryObservation ||
        name == column::kTruncationObservation) {
      SINEW_RETURN_IF_ERROR(MirrorColumn(mirror.observation, column));
    } else if (name == column::kAction || name == column::kActionMean) {
      SINEW_RETURN_IF_ERROR(MirrorColumn(mirror.action, column));
    }
  }
  return mirrored;
}

}  // namespace sinew
