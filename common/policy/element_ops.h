#ifndef SINEW_COMMON_POLICY_ELEMENT_OPS_H_
#define SINEW_COMMON_POLICY_ELEMENT_OPS_H_

#include "common/policy/row_ops.h"

namespace sinew::policy::internal {

// The operations that work element by element, for RunStep: activations,
// sums and products, AFFINE, NORMALISE and CLAMP.
bool IsElementOp(v1::Op op);
void RunElementOp(const StepArguments& arguments);

}  // namespace sinew::policy::internal

#endif  // SINEW_COMMON_POLICY_ELEMENT_OPS_H_
