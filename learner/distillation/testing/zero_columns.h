#ifndef SINEW_LEARNER_DISTILLATION_TESTING_ZERO_COLUMNS_H_
#define SINEW_LEARNER_DISTILLATION_TESTING_ZERO_COLUMNS_H_

#include <cstdint>
#include <string>

#include "common/segment/segment_layout.h"
#include "proto/sinew/v1/rollout.pb.h"

namespace sinew::learner {

// Adds all columns of a layout with zeros in them: of so many steps and
// environments, without truncated steps.
inline void AddZeroColumns(const v1::SegmentLayout& layout, int64_t steps,
                           int64_t environments, v1::Segment& segment) {
  for (const v1::SegmentLayout::Column& column : layout.columns()) {
    v1::Tensor& tensor = *segment.add_columns();
    tensor.set_name(column.name());
    tensor.set_dtype(column.dtype());
    if (column.lead() == v1::SegmentLayout::LEAD_STEP) tensor.add_shape(steps);
    const bool none = column.lead() == v1::SegmentLayout::LEAD_TRUNCATION;
    tensor.add_shape(none ? 0 : environments);
    tensor.mutable_shape()->MergeFrom(column.shape());
    int64_t bytes = ElementBytes(column.dtype());
    for (const int64_t extent : tensor.shape()) bytes *= extent;
    tensor.set_data(std::string(bytes, '\0'));
  }
}

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_DISTILLATION_TESTING_ZERO_COLUMNS_H_
