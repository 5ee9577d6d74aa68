#include "replay/testing/segments.h"

#include <cstring>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/check.h"
#include "common/digest.h"
#include "common/segment/segment_layout.h"

namespace sinew::replay {
namespace {

constexpr int kObservationWidth = 4;
constexpr int kActionWidth = 2;

// Small numbers that are 0 for flags and indices.
void Fill(const v1::SegmentLayout::Column& column, int64_t order_id,
          v1::Tensor& tensor) {
  int64_t count = 1;
  for (int64_t extent : tensor.shape()) count *= extent;
  tensor.mutable_data()->assign(count * ElementBytes(column.dtype()), '\0');
  if (column.dtype() != v1::DATA_TYPE_FLOAT32) return;
  for (int64_t i = 0; i < count; ++i) {
    const float value = static_cast<float>(order_id) + 0.25f * i;
    std::memcpy(tensor.mutable_data()->data() + i * sizeof(float), &value,
                sizeof(float));
  }
}

std::string SnapshotDigest(int64_t iteration) {
  return Sha256Hex(absl::StrCat("snapshot ", iteration));
}

}  // namespace

v1::SegmentLayout TestLayout() {
  return MakeSegmentLayout(kObservationWidth, kActionWidth);
}

v1::OpenRequest::Expected MakeExpected(int64_t order_id, int64_t iteration) {
  v1::OpenRequest::Expected expected;
  expected.set_order_id(order_id);
  expected.set_iteration(iteration);
  expected.set_snapshot_version(iteration);
  expected.set_snapshot_sha256(SnapshotDigest(iteration));
  expected.set_layout_sha256(LayoutSha256(TestLayout()));
  expected.set_environments(kEnvironments);
  expected.set_steps(kSteps);
  return expected;
}

Expectation MakeExpectation(int64_t order_id) {
  return {.run_id = kRun,
          .expected = MakeExpected(order_id),
          .layout = std::make_shared<const v1::SegmentLayout>(TestLayout()),
          .limits = nullptr};
}

v1::OpenRequest MakeOpen(absl::Span<const int64_t> order_ids, int64_t iteration,
                         bool reset) {
  v1::OpenRequest request;
  request.set_run_id(kRun);
  request.set_reset(reset);
  *request.mutable_layout() = TestLayout();
  for (int64_t id : order_ids) {
    *request.add_expected() = MakeExpected(id, iteration);
  }
  return request;
}

v1::Segment MakeSegment(int64_t order_id, int64_t iteration) {
  const v1::OpenRequest::Expected expected = MakeExpected(order_id, iteration);
  v1::Segment segment;
  segment.set_run_id(kRun);
  segment.set_order_id(order_id);
  segment.set_kind(v1::Order::KIND_TRAIN);
  segment.set_iteration(iteration);
  segment.set_snapshot_version(expected.snapshot_version());
  segment.set_snapshot_sha256(expected.snapshot_sha256());
  segment.set_layout_sha256(expected.layout_sha256());
  const v1::SegmentLayout layout = TestLayout();
  for (const auto& column : layout.columns()) {
    v1::Tensor* tensor = segment.add_columns();
    tensor->set_name(column.name());
    tensor->set_dtype(column.dtype());
    if (column.lead() == v1::SegmentLayout::LEAD_STEP) {
      tensor->add_shape(kSteps);
    }
    tensor->add_shape(column.lead() == v1::SegmentLayout::LEAD_TRUNCATION
                          ? 0
                          : kEnvironments);
    tensor->mutable_shape()->MergeFrom(column.shape());
    Fill(column, order_id, *tensor);
  }
  for (int i = 0; i < kEnvironments; ++i) {
    segment.add_end_states()->add_physics(0.5 * i);
  }
  return segment;
}

std::string MakeSegmentBytes(int64_t order_id, int64_t iteration) {
  return SerializeDeterministically(MakeSegment(order_id, iteration));
}

v1::Tensor& Column(v1::Segment& segment, absl::string_view name) {
  v1::Tensor* column = FindColumn(segment, name);
  SINEW_CHECK(column != nullptr) << "no column " << name;
  return *column;
}

}  // namespace sinew::replay
