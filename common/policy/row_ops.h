#ifndef SINEW_COMMON_POLICY_ROW_OPS_H_
#define SINEW_COMMON_POLICY_ROW_OPS_H_

#include <cstdint>

#include "absl/types/span.h"
#include "common/policy/aligned_buffer.h"
#include "common/policy/plan.h"

namespace sinew::policy::internal {

// A value's rows while a graph runs.
struct Rows {
  float* data = nullptr;
  int64_t stride = 0;
  int64_t width = 0;

  float* row(int64_t r) const { return data + r * stride; }
};

// What one step reads and writes.
struct StepArguments {
  const Step& step;
  int64_t batch;
  absl::Span<const Rows> values;
  const AlignedBuffer* parameters;
  // Scratch of Plan::patch_elements and Plan::result_elements.
  float* patches;
  float* results;

  const Rows& input(size_t i) const { return values[step.inputs[i]]; }
  const Rows& output() const { return values[step.output]; }
};

// Evaluates one step. Each row of the result is computed from that row of the
// inputs by a sequence of operations that depends on widths only. Linear layers
// also compute the rows up to the next multiple of kRowBlock, which the
// buffers must have. No allocation.
void RunStep(const StepArguments& arguments);

}  // namespace sinew::policy::internal

#endif  // SINEW_COMMON_POLICY_ROW_OPS_H_
