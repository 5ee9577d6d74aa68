#include "common/segment/segment_size.h"

#include <algorithm>

#include "common/segment/segment_layout.h"

namespace sinew {
namespace {

constexpr double kMost = int64_t{1} << 62;
// Message headers and names of columns.
constexpr double kHeaderBytes = 64 << 10;
// The physics row, previous target and episode of an environment (some 2 KiB
// for a humanoid).
constexpr double kEnvironmentBytes = 16 << 10;
// An episode that ended: at most one a step.
constexpr double kEpisodeBytes = 64;
// The errors of each body (some 300 bytes for a humanoid), and where a body
// went on, should it do so every few frames.
constexpr double kResultBytes = 4 << 10;

double RowBytes(const v1::SegmentLayout::Column& column) {
  double bytes = static_cast<double>(ElementBytes(column.dtype()));
  for (int64_t extent : column.shape()) bytes *= static_cast<double>(extent);
  return bytes;
}

}  // namespace

int64_t MaxTrainingBytes(const v1::SegmentLayout& layout, int64_t environments,
                         int64_t steps) {
  const double boundary = static_cast<double>(environments);
  const double rows = boundary * static_cast<double>(steps);
  double bytes =
      kHeaderBytes + boundary * kEnvironmentBytes + rows * kEpisodeBytes;
  for (const v1::SegmentLayout::Column& column : layout.columns()) {
    const bool once = column.lead() == v1::SegmentLayout::LEAD_BOUNDARY;
    bytes += (once ? boundary : rows) * RowBytes(column);
  }
  return static_cast<int64_t>(std::min(bytes, kMost));
}

int64_t MaxEvaluationBytes(int64_t starts) {
  const double bytes =
      kHeaderBytes + static_cast<double>(starts) * kResultBytes;
  return static_cast<int64_t>(std::min(bytes, kMost));
}

}  // namespace sinew
